/* A host with an Embree of its own, whose symbols come first for everything that is looked up by name: rays of the
 * library hit all the same, and the host's Embree is left alone. */
#include "../../c/check.h"

extern int other_embree_calls;
void *rtcIntersect1(void);

int main(void) {
    RlvContext context = RLV_NULL;
    RlvCaster caster = RLV_NULL;
    CHECK(rtcIntersect1() != NULL && other_embree_calls == 1);
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 2, 2);
    CHECK_OK(rlv_caster_create_mesh(context, plane, &caster));
    static const float origin[3] = {0.5f, 0.5f, 1}, direction[3] = {0, 0, -1};
    const RlvHit hit = check_cast(caster, origin, direction);
    CHECK_NEAR(hit.distance, 1, 1e-6);
    CHECK(hit.face == 0);
    CHECK(other_embree_calls == 1);
    CHECK_OK(rlv_caster_release(caster));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
