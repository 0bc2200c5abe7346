/* Wine before 8.10 has no bcryptprimitives.dll, which Rust's standard library takes its hash seeds from; every Windows 10 has it.
 * RtlGenRandom of advapi32 gives the same. */
#include <windows.h>
#include <stddef.h>

BOOLEAN NTAPI SystemFunction036(PVOID, ULONG);

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE bytes, SIZE_T count) {
    return SystemFunction036(bytes, (ULONG)count);
}
