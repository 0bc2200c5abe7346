//! One shared library for Macs of both processors.
//!
//! FMI 2.0 has the one folder `binaries/darwin64`, and most importers look nowhere else, on Intel and on Apple silicon. macOS has files for that:
//! several libraries behind one header ("fat" in <mach-o/fat.h>, "universal" elsewhere), of which the loader takes the one that fits.

/// Opens a file with several libraries; all numbers of its header are big-endian.
const MAGIC: u32 = 0xcafe_babe;

/// The libraries start at multiples of two to this power: pages of Apple silicon have 16 kB.
const ALIGNMENT: u32 = 14;

/// The libraries, one for each processor, in one file. Nothing if a library has no header of its own or the file would exceed 4 GB, which the format cannot express.
pub fn universal(libraries: &[&[u8]]) -> Option<Vec<u8>> {
    let mut file = Vec::new();
    let put = |file: &mut Vec<u8>, number: u32| file.extend_from_slice(&number.to_be_bytes());
    put(&mut file, MAGIC);
    put(&mut file, u32::try_from(libraries.len()).ok()?);
    let page = 1_usize << ALIGNMENT;
    let mut offset = page;
    for library in libraries {
        // What a library says of itself: processor and its variant.
        for place in [4, 8] {
            put(&mut file, u32::from_le_bytes(library.get(place..place + 4)?.try_into().ok()?));
        }
        put(&mut file, u32::try_from(offset).ok()?);
        put(&mut file, u32::try_from(library.len()).ok()?);
        put(&mut file, ALIGNMENT);
        offset = (offset + library.len()).next_multiple_of(page);
    }
    for library in libraries {
        file.resize(file.len().next_multiple_of(page), 0);
        file.extend_from_slice(library);
    }
    Some(file)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_library_lies_where_the_header_says() {
        let library = |processor: u32, length: usize| {
            let mut bytes = [0xfeed_facf_u32, processor, 3].map(u32::to_le_bytes).concat();
            bytes.resize(length, 7);
            bytes
        };
        let (intel, apple) = (library(0x0100_0007, 20_000), library(0x0100_000c, 16_384));
        let file = universal(&[&intel, &apple]).unwrap();
        let number = |place: usize| u32::from_be_bytes(file[place..place + 4].try_into().unwrap()) as usize;
        assert_eq!([number(0), number(4)], [0xcafe_babe, 2]);
        for (index, own) in [intel, apple].iter().enumerate() {
            let [processor, variant, offset, size, power] =
                std::array::from_fn(|field| number(8 + 20 * index + 4 * field));
            assert_eq!([processor as u32, variant as u32], [0x0100_0007 + 5 * index as u32, 3]);
            assert_eq!(offset % (1 << power), 0);
            assert_eq!(file[offset..offset + size], own[..]);
        }
        assert_eq!(file.len(), 16_384 + 32_768 + 16_384);
        assert_eq!(universal(&[b"text"]), None);
    }
}
