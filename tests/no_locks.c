/* For LD_PRELOAD: a file system without locks. NOLOCK_ERRNO: what asking for one fails with; NOLOCK_BYTES: only locks of bytes
 * fail, and those of whole files work; NOLOCK_NFS: files below this folder seem to lie on NFS. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdlib.h>
#include <string.h>
#include <sys/vfs.h>

static int refuse(void)
{
  const char *number = getenv("NOLOCK_ERRNO");
  errno = number ? atoi(number) : ENOLCK;
  return -1;
}

static int control(const char *name, int file, int command, void *argument)
{
  int (*next)(int, int, ...) = dlsym(RTLD_NEXT, name);
  const int locks = command == F_SETLK || command == F_SETLKW || command == F_OFD_SETLK || command == F_OFD_SETLKW;
  return locks ? refuse() : next(file, command, argument);
}

#define CONTROL(name)                                                                                                             \
  int name(int file, int command, ...)                                                                                            \
  {                                                                                                                               \
    va_list all;                                                                                                                  \
    va_start(all, command);                                                                                                       \
    void *const argument = va_arg(all, void *);                                                                                   \
    va_end(all);                                                                                                                  \
    return control(#name, file, command, argument);                                                                               \
  }
CONTROL(fcntl)
CONTROL(fcntl64)

int flock(int file, int order)
{
  int (*next)(int, int) = dlsym(RTLD_NEXT, "flock");
  return getenv("NOLOCK_BYTES") ? next(file, order) : refuse();
}

static int is_remote(const char *path)
{
  const char *folder = getenv("NOLOCK_NFS");
  return folder && strncmp(path, folder, strlen(folder)) == 0;
}

#define KIND(name)                                                                                                                \
  int name(const char *path, struct name *kind)                                                                                   \
  {                                                                                                                               \
    int (*next)(const char *, struct name *) = dlsym(RTLD_NEXT, #name);                                                           \
    const int result = next(path, kind);                                                                                          \
    if (is_remote(path)) kind->f_type = 0x6969;                                                                                   \
    return result;                                                                                                                \
  }
KIND(statfs)
KIND(statfs64)
