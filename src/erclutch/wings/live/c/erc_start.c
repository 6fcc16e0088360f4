#define _GNU_SOURCE
#include "erc_start.h"

#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>

#ifndef MAP_POPULATE /* macOS: pages come when they are touched */
#define MAP_POPULATE 0
#endif

void erc_fail(const char *format, ...) {
    va_list arguments;
    va_start(arguments, format);
    (void)fputs("erclutch-loop: ", stderr);
    (void)vfprintf(stderr, format, arguments);
    (void)fputc('\n', stderr);
    va_end(arguments);
    exit(2);
}

void *erc_file_map(const char *path, int shared, size_t *size) {
    struct stat about;
    const int file = open(path, (shared ? O_RDWR : O_RDONLY) | O_CLOEXEC);
    if (file < 0 || fstat(file, &about) != 0) {
        erc_fail("%s cannot be opened: %s", path, strerror(errno));
    }
    *size = (size_t)about.st_size;
    const int access = shared ? PROT_READ | PROT_WRITE : PROT_READ;
    void *map = mmap(0, *size, access, (shared ? MAP_SHARED : MAP_PRIVATE) | MAP_POPULATE, file, 0);
    (void)close(file);
    if (map == MAP_FAILED) {
        erc_fail("%s of %zu bytes cannot be mapped: %s", path, *size, strerror(errno));
    }
    return map;
}

void *erc_library(const char *what, const char *path) {
    void *library = dlopen(path, RTLD_NOW | RTLD_LOCAL);
    if (library == 0) {
        erc_fail("%s cannot be loaded: %s", what, dlerror());
    }
    return library;
}

void erc_symbol(void *library, const char *path, const char *name, void *function) {
    void *found = dlsym(library, name);
    if (found == 0) {
        erc_fail("the library %s has no %s", path, name);
    }
    memcpy(function, &found, sizeof found); /* POSIX lets an object pointer be a function's, ISO C has no cast for it */
}
