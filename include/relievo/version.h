/* Relievo: the version of the headers and of the library, and how functions are declared. */
#ifndef RELIEVO_VERSION_H
#define RELIEVO_VERSION_H

#include <stddef.h>
#include <stdint.h>

#ifdef __cplusplus
#define RLV_EXTERN_C extern "C"
#else
#define RLV_EXTERN_C extern
#endif

/* Functions of the shared library; define RLV_STATIC to link the static one. */
#if defined(_WIN32) && !defined(RLV_STATIC)
#define RLV_API RLV_EXTERN_C __declspec(dllimport)
#else
#define RLV_API RLV_EXTERN_C
#endif

/* Version of these headers. Until 1.0 a new minor version may change the ABI and has its own SONAME. */
#define RLV_VERSION_MAJOR 0
#define RLV_VERSION_MINOR 1
#define RLV_VERSION_PATCH 0

/* Versions as one number that can be compared. */
#define RLV_MAKE_VERSION(major, minor, patch) \
    (((uint32_t)(major) << 22) | ((uint32_t)(minor) << 12) | (uint32_t)(patch))
#define RLV_VERSION RLV_MAKE_VERSION(RLV_VERSION_MAJOR, RLV_VERSION_MINOR, RLV_VERSION_PATCH)

/* The version of the library that is loaded, as RLV_MAKE_VERSION makes it. A plugin that loads the library itself
 * should refuse another major or, until 1.0, another minor version than RLV_VERSION. */
RLV_API uint32_t rlv_version(void);

/* The initial value of every handle: no object. */
#define RLV_NULL {0}

/* Bytes of names that functions write, the terminating NUL included. */
#define RLV_NAME_SIZE 48

/* Bytes of longer texts that functions write, the terminating NUL included; longer ones are cut. */
#define RLV_TEXT_SIZE 256

#endif
