/* Preloaded into a process, stops it at one of its calls that change the disk, or lets them fail from there on.
 *
 * STOP_AT=N  the call, from 1; 0 for none     STOP_HOW  what happens:
 *   before, after  SIGKILL before or after the call      half  SIGKILL after half of what is written (else as `after`)
 *   full           from there on the disk is full        denied  from there on nothing may be created, renamed, removed
 *   broken         this one call fails
 * STOP_COUNT=FILE  takes the number of calls, when the process ends by itself.
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdarg.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <unistd.h>

static long stop_at;
static const char *how = "";
static atomic_long calls;

__attribute__((constructor)) static void begin(void) {
    const char *at = getenv("STOP_AT"), *named = getenv("STOP_HOW");
    stop_at = at ? atol(at) : 0;
    how = named ? named : "";
}

__attribute__((destructor)) static void end(void) {
    const char *path = getenv("STOP_COUNT");
    FILE *file = path ? fopen(path, "w") : NULL;
    if (!file) return;
    /* Of the calls so far, that is without those for this file. */
    fprintf(file, "%ld\n", atomic_load(&calls));
    fclose(file);
}

static int is(const char *name) { return strcmp(how, name) == 0; }

/* Counts a call; the error it must fail with, 0 if it goes on. `grows`: needs room; `names`: changes a folder. */
static int enter(long number, int grows, int names) {
    if (!stop_at || number < stop_at) return 0;
    if (is("full")) return grows ? ENOSPC : 0;
    if (is("denied")) return names ? EACCES : 0;
    if (number > stop_at) return 0;
    if (is("broken")) return EIO;
    if (is("before")) kill(getpid(), SIGKILL);
    return 0;
}

static void leave(long number) {
    if (stop_at && number == stop_at && (is("after") || is("half"))) kill(getpid(), SIGKILL);
}

/* Not what is said, wherever that goes. */
static int regular(int fd) {
    struct stat told;
    return fd > STDERR_FILENO && fstat(fd, &told) == 0 && S_ISREG(told.st_mode);
}

#define REAL(name) static __typeof__(&name) real; if (!real) real = (__typeof__(&name))dlsym(RTLD_NEXT, #name)
#define GUARDED(grows, names, call) do { \
        long number = atomic_fetch_add(&calls, 1) + 1; \
        int error = enter(number, grows, names); \
        if (error) { errno = error; return -1; } \
        __typeof__(call) answer = call; \
        leave(number); \
        return answer; \
    } while (0)

ssize_t write(int fd, const void *bytes, size_t count) {
    REAL(write);
    if (!regular(fd)) return real(fd, bytes, count);
    if (stop_at && is("half") && atomic_load(&calls) + 1 == stop_at) real(fd, bytes, count / 2), kill(getpid(), SIGKILL);
    GUARDED(1, 0, real(fd, bytes, count));
}

ssize_t writev(int fd, const struct iovec *parts, int count) {
    REAL(writev);
    if (!regular(fd)) return real(fd, parts, count);
    GUARDED(1, 0, real(fd, parts, count));
}

static int changes(int flags) { return (flags & (O_CREAT | O_TRUNC | O_WRONLY | O_RDWR)) != 0; }

#define OPENS(name) int name(const char *path, int flags, ...) { \
        REAL(name); \
        va_list more; va_start(more, flags); int mode = flags & O_CREAT ? va_arg(more, int) : 0; va_end(more); \
        if (!changes(flags) || strncmp(path, "/dev/", 5) == 0) return real(path, flags, mode); \
        GUARDED((flags & O_CREAT) != 0, 1, real(path, flags, mode)); \
    }
OPENS(open)
OPENS(open64)

int mkdir(const char *path, mode_t mode) { REAL(mkdir); GUARDED(1, 1, real(path, mode)); }
int rename(const char *from, const char *to) { REAL(rename); GUARDED(0, 1, real(from, to)); }
int unlink(const char *path) { REAL(unlink); GUARDED(0, 1, real(path)); }
int unlinkat(int fd, const char *path, int flags) { REAL(unlinkat); GUARDED(0, 1, real(fd, path, flags)); }
int rmdir(const char *path) { REAL(rmdir); GUARDED(0, 1, real(path)); }
int ftruncate64(int fd, off64_t length) { REAL(ftruncate64); GUARDED(0, 0, real(fd, length)); }
int fsync(int fd) { REAL(fsync); GUARDED(0, 0, real(fd)); }
int fdatasync(int fd) { REAL(fdatasync); GUARDED(0, 0, real(fd)); }
