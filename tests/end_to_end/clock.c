// Clocks that jump, put under a program by LD_PRELOAD: the file that ASPHERA_CLOCK names holds by how many seconds the wall clock
// does. ASPHERA_SUSPENDED names a file for the clock that goes on while a computer is suspended.

#define _GNU_SOURCE
#include <dlfcn.h>
#include <fcntl.h>
#include <stdlib.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

int clock_gettime(clockid_t clock, struct timespec *time) {
    static __typeof__(&clock_gettime) real;
    if (!real) real = (__typeof__(real))dlsym(RTLD_NEXT, "clock_gettime");
    int result = real(clock, time);
    const char *path = clock == CLOCK_REALTIME   ? getenv("ASPHERA_CLOCK")
                       : clock == CLOCK_BOOTTIME ? getenv("ASPHERA_SUSPENDED")
                                                 : 0;
    int file = path ? (int)syscall(SYS_openat, AT_FDCWD, path, O_RDONLY) : -1;
    if (file >= 0) {
        char text[32] = {0};
        if (read(file, text, sizeof text - 1) > 0) time->tv_sec += atol(text);
        close(file);
    }
    return result;
}
