/* Stands in for a library of Windows that Wine 8 lacks, from which Rust's standard library takes random numbers. */
#include <windows.h>

/* RtlGenRandom, as advapi32 exports it. */
BOOLEAN NTAPI SystemFunction036(PVOID data, ULONG length);

__declspec(dllexport) BOOL WINAPI ProcessPrng(PBYTE data, SIZE_T length) {
    const SIZE_T largest = 1 << 20;
    while (length > 0) {
        SIZE_T part = length < largest ? length : largest;
        if (!SystemFunction036(data, (ULONG)part)) {
            return FALSE;
        }
        data += part;
        length -= part;
    }
    return TRUE;
}
