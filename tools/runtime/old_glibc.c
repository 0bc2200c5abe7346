/* Rust's standard library, linked on a system of today, asks for functions by names or versions that glibc has only had
 * since 2.30, 2.33 and 2.34. These stand in for them, inside the shared library only, and need glibc 2.28 or less. */
#include <fcntl.h>
#include <sys/syscall.h>
#include <unistd.h>

#if defined(__x86_64__)
#define FIRST "GLIBC_2.2.5"
#elif defined(__aarch64__)
#define FIRST "GLIBC_2.17"
#else
#error "the first version of glibc for this processor is not known"
#endif

/* The version that libpthread had from the beginning, and that libc still has. */
#define FIRST_VERSION(name) __asm__(".symver first_" #name ", " #name "@" FIRST)

FIRST_VERSION(pthread_key_create);
FIRST_VERSION(pthread_key_delete);
FIRST_VERSION(pthread_setspecific);
int first_pthread_key_create(unsigned *key, void (*destroy)(void *));
int first_pthread_key_delete(unsigned key);
int first_pthread_setspecific(unsigned key, const void *value);

int pthread_key_create(unsigned *key, void (*destroy)(void *)) { return first_pthread_key_create(key, destroy); }
int pthread_key_delete(unsigned key) { return first_pthread_key_delete(key); }
int pthread_setspecific(unsigned key, const void *value) { return first_pthread_setspecific(key, value); }

/* The kernel fills what glibc calls struct stat64 on these processors. */
int fstat64(int file, void *status) { return (int)syscall(SYS_fstat, file, status); }
int stat64(const char *path, void *status) { return (int)syscall(SYS_newfstatat, AT_FDCWD, path, status, 0); }

int gettid(void) { return (int)syscall(SYS_gettid); }
