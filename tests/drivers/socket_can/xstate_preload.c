// Preloaded into user-mode-linux. Its kernel 6.1 keeps 2696 bytes of its processes' extended registers,
// as much as AVX-512 needs. Processors with AMX have 11 KiB, and Linux since 5.16 refuses to set less
// than all of them (EFAULT), so no process would start. This hands the front part to user-mode-linux
// and leaves the rest as it is; nothing that runs in it asks the kernel for AMX.

#define _GNU_SOURCE
#include <dlfcn.h>
#include <stdarg.h>
#include <stdint.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/uio.h>

enum { kXstate = 0x202 /* NT_X86_XSTATE */, kPresentBits = 512 /* offset of xstate_bv */ };
// Components below offset 2696: x87, SSE, AVX, MPX, AVX-512, PKRU.
static const uint64_t kFront = 0x2FF;

typedef long (*Ptrace)(int request, long process, void* address, void* data);

static unsigned char whole[1 << 16];  // one kernel thread uses it at a time

static void keep_front_bits(unsigned char* state) {
  uint64_t present;
  memcpy(&present, state + kPresentBits, sizeof present);
  present &= kFront;
  memcpy(state + kPresentBits, &present, sizeof present);
}

long ptrace(enum __ptrace_request request, ...) {
  static Ptrace real;
  if (!real) real = (Ptrace)dlsym(RTLD_NEXT, "ptrace");
  va_list arguments;
  va_start(arguments, request);
  const long process = va_arg(arguments, long);
  void* address = va_arg(arguments, void*);
  void* data = va_arg(arguments, void*);
  va_end(arguments);
  const int is_get = request == PTRACE_GETREGSET, is_set = request == PTRACE_SETREGSET;
  if (!(is_get || is_set) || (long)address != kXstate) {
    return real((int)request, process, address, data);
  }
  struct iovec* part = data;
  struct iovec all = {whole, sizeof whole};
  const long result = real(PTRACE_GETREGSET, process, address, &all);
  if (result < 0) return result;
  if (part->iov_len > all.iov_len) part->iov_len = all.iov_len;
  if (is_get) {
    memcpy(part->iov_base, whole, part->iov_len);
    if (part->iov_len >= kPresentBits + 8) keep_front_bits(part->iov_base);
    return result;
  }
  memcpy(whole, part->iov_base, part->iov_len);
  keep_front_bits(whole);
  return real(PTRACE_SETREGSET, process, address, &all);
}
