/* A module of a host, with the static library inside and one function of its own. */
#include <relievo/relievo.h>

int press_plane(void);

int press_plane(void) {
    RlvContext context = RLV_NULL;
    return rlv_version() == RLV_VERSION && rlv_context_create(NULL, &context) == RLV_OK &&
           rlv_context_release(context) == RLV_OK;
}
