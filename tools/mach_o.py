"""Checks shared libraries for macOS where there is no Mac: what the loader reads of their headers, and the functions that they offer.

usage: mach_o.py LIBRARY OLDEST_MACOS PROCESSOR...     one library, or a universal one with one library for each processor (x86_64, arm64)

Layouts are those of <mach-o/loader.h>, <mach-o/fat.h> and <mach-o/nlist.h>.
"""

import struct
import sys
from pathlib import Path

PROCESSORS = {0x01000007: "x86_64", 0x0100000C: "arm64"}
DYLIB = 6
SYMTAB, ID_DYLIB, CODE_SIGNATURE, BUILD_VERSION = 0x2, 0xD, 0x1D, 0x32
LOADED = {0xC, 0x20, 0x23, 0x80000018, 0x8000001F}  # with the lazy, upward, weak and re-exported ones
MACOS = 1
SYSTEM = "/usr/lib/libSystem.B.dylib"


def parts(data):
    """The libraries of a file: several behind a universal header, or itself."""
    magic, count = struct.unpack_from(">2I", data)
    if magic != 0xCAFEBABE:
        return [data]
    places = [struct.unpack_from(">5I", data, 8 + 20 * index) for index in range(count)]
    for processor, _, offset, _, power in places:
        assert offset % (1 << power) == 0, f"{PROCESSORS[processor]}: offset {offset} is not aligned"
    return [data[offset : offset + size] for _, _, offset, size, _ in places]


def text(data, offset):
    return data[offset : data.index(b"\0", offset)].decode()


def commands(library):
    """The load commands: number, and the bytes of each."""
    count, offset = struct.unpack_from("<I", library, 16)[0], 32
    for _ in range(count):
        number, size = struct.unpack_from("<2I", library, offset)
        yield number, library[offset : offset + size]
        offset += size


def functions(library, command):
    """Names that others can call."""
    offset, count, names = struct.unpack_from("<3I", command, 8)
    for index in range(count):
        name, kind = struct.unpack_from("<IB", library, offset + 16 * index)
        if kind & 0x01 and kind & 0x0E == 0x0E:  # external and in a section
            yield text(library, names + name)


def check(library, oldest):
    magic, processor, _, kind = struct.unpack_from("<4I", library)
    assert (magic, kind) == (0xFEEDFACF, DYLIB), "not a shared library for macOS"
    processor = PROCESSORS[processor]
    own = list(commands(library))
    [(platform, version)] = [struct.unpack_from("<2I", command, 8) for number, command in own if number == BUILD_VERSION]
    version = (version >> 16, version >> 8 & 0xFF)
    assert platform == MACOS and version <= oldest, f"{processor}: needs macOS {version}"
    needed = {text(command, struct.unpack_from("<I", command, 8)[0]) for number, command in own if number in LOADED}
    assert needed == {SYSTEM}, f"{processor}: needs {needed}"
    [name] = [text(command, struct.unpack_from("<I", command, 8)[0]) for number, command in own if number == ID_DYLIB]
    assert name.startswith("@rpath/"), f"{processor}: is called {name}"
    # The system of Apple silicon loads nothing that is not signed.
    assert processor != "arm64" or any(number == CODE_SIGNATURE for number, _ in own), "arm64: not signed"
    [symbols] = [command for number, command in own if number == SYMTAB]
    offered = {name.removeprefix("_") for name in functions(library, symbols)}
    count = [sum(name.startswith(prefix) for name in offered) for prefix in ("fmi2", "fmi3")]
    assert {"fmi2Instantiate", "fmi2DoStep", "fmi3InstantiateCoSimulation", "fmi3DoStep"} <= offered, f"{processor}: functions of FMI are missing"
    print(f"{processor}: macOS {version[0]}.{version[1]}, {SYSTEM}, {count[0]} functions of FMI 2.0, {count[1]} of FMI 3.0, {len(library) / 1e6:.1f} MB")
    return processor


def main(path, oldest, *processors):
    oldest = tuple(int(number) for number in oldest.split("."))
    found = [check(library, oldest) for library in parts(Path(path).read_bytes())]
    assert sorted(found) == sorted(processors), f"it is for {found}"


if __name__ == "__main__":
    main(*sys.argv[1:])
