// A disk that fails on demand, put under a program by LD_PRELOAD.
//
// The file that ASPHERA_DISK names says how: "eio", "enospc" and "erofs" are errors, "short" takes half of what is written
// and then is full, "hang" gives no answer for as long as the word stands there, "report" has no room
// for a report alone. Nothing, or no file: a disk that works.
// Only what lies in a folder of a session is met: its files, and the folder when it is made.

#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <unistd.h>

static __thread int halved;

static int word(char *into, size_t room) {
    const char *path = getenv("ASPHERA_DISK");
    long file = path ? syscall(SYS_openat, AT_FDCWD, path, O_RDONLY) : -1;
    long length = file < 0 ? 0 : syscall(SYS_read, (int)file, into, room - 1);
    if (file >= 0) syscall(SYS_close, (int)file);
    into[length > 0 ? length : 0] = 0;
    return length > 0;
}

// 0: go on. Else what errno is to be; -1: half of a write.
static int fault(void) {
    char how[16];
    while (word(how, sizeof how)) {
        if (!strncmp(how, "eio", 3)) return EIO;
        if (!strncmp(how, "enospc", 6)) return ENOSPC;
        if (!strncmp(how, "erofs", 5)) return EROFS;
        if (!strncmp(how, "short", 5)) return halved ? ENOSPC : -1;
        if (strncmp(how, "hang", 4)) return 0;
        usleep(5000);
    }
    return 0;
}

// A report that is to find no room.
static int is_refused_report(const char *path) {
    char how[16];
    return strstr(path, "/report.") && word(how, sizeof how) && !strncmp(how, "report", 6);
}

static int is_session(const char *path) { return strstr(path, "/session-") != 0; }

static int is_session_file(int file) {
    char link[64], path[4096];
    snprintf(link, sizeof link, "/proc/self/fd/%d", file);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length <= 0) return 0;
    path[length] = 0;
    return is_session(path);
}

#define REAL(name) ((__typeof__(&name))dlsym(RTLD_NEXT, #name))

ssize_t write(int file, const void *bytes, size_t count) {
    if (is_session_file(file)) {
        int error = fault();
        if (error == -1 && count > 1) {
            halved = 1;
            return REAL(write)(file, bytes, count / 2);
        }
        if (error > 0) { errno = error; return -1; }
    }
    return REAL(write)(file, bytes, count);
}

#define ON_FILE(name)                                              \
    int name(int file) {                                           \
        if (is_session_file(file)) {                               \
            int error = fault();                                   \
            if (error > 0) { errno = error; return -1; }           \
        }                                                          \
        return REAL(name)(file);                                   \
    }
ON_FILE(fsync)
ON_FILE(fdatasync)

int mkdir(const char *path, mode_t mode) {
    if (is_session(path)) {
        int error = fault();
        if (error > 0) { errno = error; return -1; }
    }
    return REAL(mkdir)(path, mode);
}

int rename(const char *from, const char *to) {
    if (is_session(to)) {
        int error = fault();
        if (error > 0) { errno = error; return -1; }
    }
    return REAL(rename)(from, to);
}

int open64(const char *path, int flags, ...) {
    va_list rest;
    va_start(rest, flags);
    mode_t mode = va_arg(rest, mode_t);
    va_end(rest);
    if ((flags & O_CREAT) && is_session(path)) {
        int error = is_refused_report(path) ? ENOSPC : fault();
        if (error > 0) { errno = error; return -1; }
    }
    return REAL(open64)(path, flags, mode);
}
