/* Relievo: adapters, the graphics devices that a context can be given.
 *
 * They can be listed before there is a context. A context opens one by its name; see RlvContextOptions. */
#ifndef RELIEVO_ADAPTER_H
#define RELIEVO_ADAPTER_H

#include "relievo/context.h"

/* What an adapter is made of, best first. */
typedef enum RlvAdapterKind {
    RLV_ADAPTER_DISCRETE = 0,   /* a graphics card */
    RLV_ADAPTER_INTEGRATED = 1, /* a graphics unit that shares the processor's memory */
    RLV_ADAPTER_VIRTUAL = 2,    /* of a virtual machine, or one that does not say what it is */
    RLV_ADAPTER_SOFTWARE = 3    /* the processor itself, as Mesa's lavapipe */
} RlvAdapterKind;

typedef struct RlvAdapterInfo {
    uint32_t kind;      /* RlvAdapterKind */
    uint32_t is_usable; /* 0 or 1: whether it has all that is needed of one */
    uint64_t buffer_limit;       /* bytes that one buffer may have */
    uint64_t binding_limit;      /* bytes of a buffer that one computation may read or write */
    char backend[RLV_NAME_SIZE]; /* "vulkan", "metal" or "dx12" */
    char name[RLV_TEXT_SIZE];    /* as its driver gives it */
    char driver[RLV_TEXT_SIZE];  /* the driver and its version */
} RlvAdapterInfo;

/* The adapters of this machine, best first, those alike in the system's order; none is no failure. Asks the drivers,
 * which takes milliseconds to tenths of a second. Writes up to capacity rows to adapters and their number to count.
 * adapters may be NULL to ask for the number. Fails if there are more than capacity. */
RLV_API RlvResult rlv_adapter_list(RlvAdapterInfo *adapters, size_t capacity, size_t *count);

#endif
