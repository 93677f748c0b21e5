/* A host with the static library inside, whose own functions have the names of libraries that others contain. */
#include "../../c/check.h"

#define PATH "static-host.relievo"

extern int own_calls;
int stbi_load(void);
int mz_compress(void);
int LoadEXR(void);
int ZSTD_compress(void);

int main(void) {
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDocument document = RLV_NULL;
    RlvBrush brush = RLV_NULL;
    RlvDocumentInfo info = RLV_DOCUMENT_INFO_INIT;
    RlvBrushOptions options = RLV_BRUSH_OPTIONS_INIT;
    RlvBrushSettings settings = RLV_BRUSH_SETTINGS_INIT;
    const RlvStrokePoint points[2] = {{{0.2, 0.5, 0}, 1.0, -1.0}, {{2.8, 2.5, 0}, 1.0, -1.0}};

    /* Documents compress what they write, and failures go through what every Rust library has. */
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 3, 3);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_document_create(detail, PATH, 0, &document));
    options.action = RLV_BRUSH_SCULPT;
    options.height = 0.1f;
    settings.radius = 0.3f;
    CHECK_OK(rlv_brush_create(context, &options, &settings, &brush));
    CHECK_OK(rlv_document_begin(document, "a stroke"));
    CHECK_OK(rlv_stroke_run(detail, brush, points, 2, 0, NULL));
    CHECK_OK(rlv_document_end(document, NULL));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_document_open(detail, PATH, 0, &document));
    CHECK_OK(rlv_document_info(document, &info));
    CHECK(info.undo_count == 1);
    CHECK_OK(rlv_document_release(document));
    CHECK(remove(PATH) == 0);
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_document_open(detail, "nowhere/none.relievo", 0, &document), "none.relievo");

    /* None of it went to the host's functions, which are all its own. */
    CHECK(own_calls == 0);
    CHECK(stbi_load() == 1 && mz_compress() == 2 && LoadEXR() == 3 && ZSTD_compress() == 4);
    CHECK_OK(rlv_brush_release(brush));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
