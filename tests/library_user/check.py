"""Checks the runtime inside an FMU that a development build exported: optimised builds are small and have no symbols."""

import struct
import sys
import zipfile

MOST = 3_000_000  # bytes; unoptimised it is more than ten times as large


def sections(library: bytes) -> set[str]:
    """Names of the sections of a 64-bit ELF file."""
    (table,) = struct.unpack_from("<Q", library, 0x28)
    size, count, names = struct.unpack_from("<HHH", library, 0x3A)
    headers = [struct.unpack_from("<IIQQQQ", library, table + index * size) for index in range(count)]
    text = headers[names][4]
    return {library[text + header[0] : library.index(b"\0", text + header[0])].decode() for header in headers}


with zipfile.ZipFile(sys.argv[1]) as fmu:
    for name in fmu.namelist():
        if name.startswith("binaries/") and name.endswith(".so"):
            library = fmu.read(name)
            found = sections(library)
            assert ".text" in found, found
            assert not found & {".symtab", ".debug_info"}, f"{name} is not stripped"
            assert len(library) < MOST, f"{name} has {len(library)} bytes: not optimised"
            print(f"{name}: {len(library)} bytes, stripped")
