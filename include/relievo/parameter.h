/* Relievo: tables of parameters, from which a host can make its panels. */
#ifndef RELIEVO_PARAMETER_H
#define RELIEVO_PARAMETER_H

#include "relievo/error.h"

typedef enum RlvParameterKind {
    RLV_PARAMETER_F32 = 0, /* float */
    RLV_PARAMETER_U32 = 1, /* uint32_t */
    RLV_PARAMETER_BOOL = 2 /* uint32_t, 0 or 1 */
} RlvParameterKind;

/* One field of a settings struct. The texts are UTF-8 and live as long as the process. */
typedef struct RlvParameter {
    const char *name; /* of the field */
    const char *unit; /* "" for a pure number, "rad", "object units" */
    const char *help; /* what it does, one sentence or two */
    uint32_t kind;    /* RlvParameterKind */
    uint32_t offset;  /* bytes from the start of the struct */
    double min;       /* smallest value */
    double max;       /* largest value */
    double value;     /* what the RLV_..._INIT has */
} RlvParameter;

#endif
