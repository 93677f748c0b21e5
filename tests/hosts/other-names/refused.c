/* Refuses files in memory, as systems do that let nothing be executed from them. */
#include <errno.h>

int memfd_create(const char *name, unsigned flags);

int memfd_create(const char *name, unsigned flags) {
    (void)name;
    (void)flags;
    errno = EACCES;
    return -1;
}
