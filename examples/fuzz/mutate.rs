//! Random damage.

/// A small generator of random numbers (SplitMix64): the same everywhere for the same seed.
pub struct Random {
    state: u64,
}

impl Random {
    pub fn new(seed: u64) -> Self {
        Self { state: seed }
    }

    fn next(&mut self) -> u64 {
        self.state = self.state.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.state;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Below a limit; 0 if the limit is 0.
    pub fn below(&mut self, limit: usize) -> usize {
        if limit == 0 { 0 } else { (self.next() % limit as u64) as usize }
    }

    /// One of these.
    pub fn pick<'a, T>(&mut self, of: &'a [T]) -> &'a T {
        &of[self.below(of.len())]
    }

    /// The ends of a short piece.
    fn piece(&mut self, length: usize) -> [usize; 2] {
        let from = self.below(length + 1);
        [from, from + self.below(length - from + 1).min(40)]
    }
}

/// Changes bytes, and leaves out, doubles and moves short pieces.
pub fn bytes(random: &mut Random, bytes: &mut Vec<u8>) {
    let [from, to] = random.piece(bytes.len());
    match random.below(6) {
        0 => drop(bytes.drain(from..to)),
        1 => {
            let piece = bytes[from..to].to_vec();
            let at = random.below(bytes.len() + 1);
            bytes.splice(at..at, piece);
        }
        2 => {
            let number = *random.pick(&[0.0, -0.0, 1.0, -1.0, f64::NAN, f64::INFINITY, 1e-320, 1e308, -1e15]);
            for (byte, new) in bytes[from..].iter_mut().zip(number.to_le_bytes()) {
                *byte = new;
            }
        }
        3 => bytes[from..to].fill(*random.pick(&[0, 1, 0x7f, 0x80, 0xff])),
        _ => {
            if from < bytes.len() {
                bytes[from] ^= 1 << random.below(8);
            }
        }
    }
}

/// What turns up in scenes, and what does not belong there.
const WORDS: [&str; 40] = [
    "0",
    "-1",
    "1e308",
    "-1e-320",
    "nan",
    "inf",
    "1e400",
    "9223372036854775808",
    "\"0 m\"",
    "\"1 N/m\"",
    "\"deg\"",
    "\"t\"",
    "\"1/0\"",
    "\"sqrt(-1)\"",
    "\"if(t < 1, 0, 1e9)\"",
    "\"-(-(-t))^0.5\"",
    "\"atan2(0, 0)\"",
    "\"floor(1e300)\"",
    "\"log(0)\"",
    "[]",
    "{}",
    "[0, 0]",
    "[1e200, -1e200]",
    "\"\"",
    "\"\u{1f980}\"",
    "true",
    "1979-05-27",
    "\"ground\"",
    "ground",
    "mass = 0.0",
    "dimension = 1",
    "type = \"weld\"",
    "angle = 0.0",
    "{ guess = 1 }",
    "{ value = 1, min = 2 }",
    "tunable = true",
    "{ input = \"x\", as = \"velocity\" }",
    "\n[initial]\n",
    "\n[coordinates]\npreset = \"joint\"\n",
    "max_step = 1e-30",
];

/// Swaps, doubles and leaves out lines, and replaces words by others of the same text or by [`WORDS`].
pub fn text(random: &mut Random, text: &str, other: &str) -> String {
    let mut lines: Vec<String> = text.lines().map(str::to_owned).collect();
    if lines.is_empty() {
        return other.to_owned();
    }
    let at = random.below(lines.len());
    match random.below(8) {
        0 => drop(lines.remove(at)),
        1 => {
            let line = lines[at].clone();
            lines.insert(random.below(lines.len() + 1), line);
        }
        2 => {
            let elsewhere = random.below(lines.len());
            lines.swap(at, elsewhere);
        }
        3 => {
            let others: Vec<&str> = other.lines().collect();
            if !others.is_empty() {
                lines.insert(at, (*random.pick(&others)).to_owned());
            }
        }
        _ => lines[at] = line(random, &lines, at),
    }
    lines.join("\n")
}

/// One word of the line replaced.
fn line(random: &mut Random, lines: &[String], at: usize) -> String {
    let words = |line: &str| -> Vec<String> { line.split(' ').map(str::to_owned).collect() };
    let mut own = words(&lines[at]);
    let place = random.below(own.len());
    own[place] = match random.below(2) {
        0 => (*random.pick(&WORDS)).to_owned(),
        _ => {
            let foreign = words(random.pick::<String>(lines));
            random.pick(&foreign).clone()
        }
    };
    own.join(" ")
}
