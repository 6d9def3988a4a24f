/* bcryptprimitives.dll, which Windows 10 has and Wine has from version 9 on, with the one function that Rust's library takes from it. */
#include <stddef.h>
#include <windows.h>

BOOLEAN NTAPI SystemFunction036(void *bytes, ULONG count);

__declspec(dllexport) BOOL WINAPI ProcessPrng(BYTE *bytes, size_t count) {
    return SystemFunction036(bytes, (ULONG)count);
}
