/* What a host may hand over by mistake to layers, documents, pictures, procedurals, jobs, Bezier patches and levels, of tiles and
 * of triangles: NULL, handles that are dead, of another noun or made up, descriptors of other sizes, numbers that are none, and two threads
 * at once. All is an error by the rules of the headers, or done. */
#include "ball.h"
#include "garbage.h"

#include <pthread.h>

static RlvResult count_layers(uint64_t id) { size_t count; return rlv_layer_count((RlvDetail){id}, &count); }
static RlvResult layer_info(uint64_t id) { RlvLayerInfo out = RLV_LAYER_INFO_INIT; return rlv_layer_info((RlvDetail){id}, 0, &out); }
static RlvResult add_layer(uint64_t id) {
    RlvLayerOptions options = RLV_LAYER_OPTIONS_INIT;
    uint32_t out = 0;
    return rlv_layer_add((RlvDetail){id}, "a", &options, &out);
}
static RlvResult set_layer(uint64_t id) { RlvLayerOptions options = RLV_LAYER_OPTIONS_INIT; return rlv_layer_set((RlvDetail){id}, 0, &options); }
static RlvResult activate(uint64_t id) { return rlv_layer_set_active((RlvDetail){id}, 0); }
static RlvResult rename_layer(uint64_t id) { return rlv_layer_rename((RlvDetail){id}, 0, "b"); }
static RlvResult place_layer(uint64_t id) { return rlv_layer_place((RlvDetail){id}, 0, 0); }
static RlvResult remove_layer(uint64_t id) { return rlv_layer_remove((RlvDetail){id}, 0); }
static RlvResult merge_layer(uint64_t id) { return rlv_layer_merge((RlvDetail){id}, 0); }
static RlvResult flatten(uint64_t id) { return rlv_layer_flatten((RlvDetail){id}); }
static RlvResult create_document(uint64_t id) { RlvDocument out; return rlv_document_create((RlvDetail){id}, NULL, 0, &out); }
static RlvResult open_document(uint64_t id) { RlvDocument out; return rlv_document_open((RlvDetail){id}, "a.relievo", 0, &out); }
static RlvResult open_bytes(uint64_t id) { RlvDocument out; return rlv_document_open_bytes((RlvDetail){id}, (const uint8_t *)"a", 1, 0, &out); }
static RlvResult save_bytes(uint64_t id) { RlvBytes out; return rlv_document_save_bytes((RlvDocument){id}, &out); }
static RlvResult mesh_of_bytes(uint64_t id) { RlvMesh out; return rlv_document_mesh_bytes((RlvContext){id}, (const uint8_t *)"a", 1, &out); }
static RlvResult retain_document(uint64_t id) { return rlv_document_retain((RlvDocument){id}); }
static RlvResult release_document(uint64_t id) { return rlv_document_release((RlvDocument){id}); }
static RlvResult document_info(uint64_t id) { RlvDocumentInfo out = RLV_DOCUMENT_INFO_INIT; return rlv_document_info((RlvDocument){id}, &out); }
static RlvResult begin(uint64_t id) { return rlv_document_begin((RlvDocument){id}, "edit"); }
static RlvResult end(uint64_t id) { return rlv_document_end((RlvDocument){id}, NULL); }
static RlvResult abandon(uint64_t id) { return rlv_document_abandon((RlvDocument){id}); }
static RlvResult undo(uint64_t id) { return rlv_document_undo((RlvDocument){id}, NULL); }
static RlvResult redo(uint64_t id) { return rlv_document_redo((RlvDocument){id}, NULL); }
static RlvResult save(uint64_t id) { return rlv_document_save((RlvDocument){id}, "garbage.relievo"); }
static RlvResult sync_document(uint64_t id) { return rlv_document_sync((RlvDocument){id}); }
static RlvResult compact(uint64_t id) { return rlv_document_compact((RlvContext){id}, "garbage.relievo", 0); }
static RlvResult document_mesh(uint64_t id) { RlvMesh out; return rlv_document_mesh((RlvContext){id}, "garbage.relievo", &out); }
static RlvResult transfer(uint64_t id) {
    return rlv_document_transfer((RlvContext){id}, (RlvMesh){id}, "garbage.relievo", "b.relievo", NULL, NULL, NULL, NULL);
}
static RlvResult open_picture(uint64_t id) { RlvPicture out; return rlv_picture_open((RlvContext){id}, "garbage.relievo", &out); }
static RlvResult retain_picture(uint64_t id) { return rlv_picture_retain((RlvPicture){id}); }
static RlvResult release_picture(uint64_t id) { return rlv_picture_release((RlvPicture){id}); }
static RlvResult picture_info(uint64_t id) { RlvPictureInfo out = RLV_PICTURE_INFO_INIT; return rlv_picture_info((RlvPicture){id}, &out); }
static RlvResult picture_image(uint64_t id) { RlvPictureImage out = RLV_PICTURE_IMAGE_INIT; return rlv_picture_image((RlvPicture){id}, 0, &out); }
static RlvResult picture_meta(uint64_t id) { RlvPictureMeta out = RLV_PICTURE_META_INIT; return rlv_picture_meta((RlvPicture){id}, 0, &out); }
static RlvResult read_picture(uint64_t id) { float out[4]; return rlv_picture_read((RlvPicture){id}, 0, 0, 0, 0, 1, 1, out, 0); }
static RlvResult create_procedural(uint64_t id) { RlvProcedural out; return rlv_procedural_create((RlvDetail){id}, NULL, &out); }
static RlvResult create_moving(uint64_t id) { RlvProcedural out; return rlv_procedural_create_moving((RlvProcedural){id}, (RlvDetail){id}, &out); }
static RlvResult retain_procedural(uint64_t id) { return rlv_procedural_retain((RlvProcedural){id}); }
static RlvResult release_procedural(uint64_t id) { return rlv_procedural_release((RlvProcedural){id}); }
static RlvResult procedural_info(uint64_t id) { RlvProceduralInfo out = RLV_PROCEDURAL_INFO_INIT; return rlv_procedural_info((RlvProcedural){id}, &out); }
static RlvResult procedural_table(uint64_t id) { RlvProceduralTable out = RLV_PROCEDURAL_TABLE_INIT; return rlv_procedural_table((RlvProcedural){id}, &out); }
static RlvResult job_tessellate(uint64_t id) { RlvJob out; return rlv_job_tessellate((RlvDetail){id}, NULL, &out); }
static RlvResult job_bake(uint64_t id) { RlvJob out; return rlv_job_bake((RlvDetail){id}, NULL, "a.exr", &out); }
static RlvResult job_ptex_write(uint64_t id) { RlvJob out; return rlv_job_ptex_write((RlvDetail){id}, 0, "a.ptx", &out); }
static RlvResult job_ptex_read(uint64_t id) { RlvJob out; return rlv_job_ptex_read((RlvDetail){id}, "a.ptx", NULL, &out); }
static RlvResult job_transfer(uint64_t id) { RlvJob out; return rlv_job_transfer((RlvContext){id}, (RlvMesh){id}, "a.relievo", "b.relievo", NULL, &out); }
static RlvResult retain_job(uint64_t id) { return rlv_job_retain((RlvJob){id}); }
static RlvResult release_job(uint64_t id) { return rlv_job_release((RlvJob){id}); }
static RlvResult poll_job(uint64_t id) { RlvJobInfo out = RLV_JOB_INFO_INIT; return rlv_job_poll((RlvJob){id}, &out); }
static RlvResult wait_job(uint64_t id) { return rlv_job_wait((RlvJob){id}, -1.0, NULL); }
static RlvResult cancel_job(uint64_t id) { return rlv_job_cancel((RlvJob){id}); }
static RlvResult job_result(uint64_t id) { return rlv_job_result((RlvJob){id}); }
static RlvResult job_mesh(uint64_t id) { RlvMesh out; return rlv_job_mesh((RlvJob){id}, &out); }
static RlvResult job_report(uint64_t id) { RlvImprintReport out = RLV_IMPRINT_REPORT_INIT; return rlv_job_imprint_report((RlvJob){id}, &out); }
static RlvResult read_bezier(uint64_t id) { RlvBezier out; return rlv_bezier_read((RlvContext){id}, "a.bpt", &out); }
static RlvResult retain_bezier(uint64_t id) { return rlv_bezier_retain((RlvBezier){id}); }
static RlvResult release_bezier(uint64_t id) { return rlv_bezier_release((RlvBezier){id}); }
static RlvResult bezier_info(uint64_t id) { RlvBezierInfo out = RLV_BEZIER_INFO_INIT; return rlv_bezier_info((RlvBezier){id}, &out); }
static RlvResult bezier_controls(uint64_t id) { float out[64]; return rlv_bezier_get_controls((RlvBezier){id}, 0, out, 0); }
static RlvResult evaluate_bezier(uint64_t id) { RlvEvaluateArrays out = RLV_EVALUATE_ARRAYS_INIT; return rlv_bezier_evaluate((RlvBezier){id}, &out); }
static RlvResult bezier_levels(uint64_t id) { RlvBezierView view = RLV_BEZIER_VIEW_INIT; uint32_t out[4]; return rlv_bezier_levels((RlvBezier){id}, &view, out, 4); }
static RlvResult count_bezier(uint64_t id) { size_t points, triangles; return rlv_bezier_count((RlvBezier){id}, NULL, &points, &triangles); }
static RlvResult bezier_mesh(uint64_t id) { RlvMesh out; return rlv_bezier_mesh((RlvBezier){id}, NULL, &out); }
static RlvResult update_buffer(uint64_t id) { return rlv_buffer_update((RlvBuffer){id}, NULL); }
static RlvResult release_buffer(uint64_t id) { return rlv_buffer_release((RlvBuffer){id}); }
static RlvResult read_buffer(uint64_t id) { float out[6]; return rlv_buffer_read((RlvBuffer){id}, 0, 1, out, 0); }
static RlvResult vulkan_buffer(uint64_t id) { RlvBufferVulkan out = RLV_BUFFER_VULKAN_INIT; return rlv_buffer_vulkan((RlvBuffer){id}, &out); }
static RlvResult simplify_mesh(uint64_t id) { RlvMesh out; return rlv_simplify_mesh((RlvMesh){id}, NULL, NULL, NULL, NULL, &out); }
static RlvResult build_progressive(uint64_t id) { RlvProgressive out; return rlv_progressive_create((RlvMesh){id}, NULL, NULL, NULL, &out); }
static RlvResult job_progressive(uint64_t id) { RlvJob out; return rlv_job_progressive((RlvMesh){id}, NULL, &out); }
static RlvResult job_simplify(uint64_t id) { RlvJob out; return rlv_job_simplify((RlvMesh){id}, NULL, &out); }
static RlvResult job_simplify_error(uint64_t id) { float out; return rlv_job_simplify_error((RlvJob){id}, &out); }
static RlvResult job_progressive_mesh(uint64_t id) { RlvProgressive out; return rlv_job_progressive_mesh((RlvJob){id}, &out); }
static RlvResult read_progressive(uint64_t id) { RlvProgressive out; return rlv_progressive_read((RlvContext){id}, "a.rlvpm", 1, &out); }
static RlvResult write_progressive(uint64_t id) { return rlv_progressive_write((RlvProgressive){id}, "a.rlvpm"); }
static RlvResult retain_progressive(uint64_t id) { return rlv_progressive_retain((RlvProgressive){id}); }
static RlvResult release_progressive(uint64_t id) { return rlv_progressive_release((RlvProgressive){id}); }
static RlvResult progressive_info(uint64_t id) { RlvProgressiveInfo out = RLV_PROGRESSIVE_INFO_INIT; return rlv_progressive_info((RlvProgressive){id}, &out); }
static RlvResult create_level(uint64_t id) { RlvLevel out; return rlv_level_create((RlvProgressive){id}, &out); }
static RlvResult retain_level(uint64_t id) { return rlv_level_retain((RlvLevel){id}); }
static RlvResult take_up(uint64_t id) { return rlv_level_take_up((RlvLevel){id}, (RlvProgressive){id}); }
static RlvResult release_level(uint64_t id) { return rlv_level_release((RlvLevel){id}); }
static RlvResult level_info(uint64_t id) { RlvLevelInfo out = RLV_LEVEL_INFO_INIT; return rlv_level_info((RlvLevel){id}, &out); }
static RlvResult level_error(uint64_t id) { return rlv_level_set_error((RlvLevel){id}, 0.0f); }
static RlvResult level_bound(uint64_t id) { return rlv_level_set_bound((RlvLevel){id}, 0.0f, NULL, NULL, NULL); }
static RlvResult level_triangles(uint64_t id) { return rlv_level_set_triangles((RlvLevel){id}, 9); }
static RlvResult level_view(uint64_t id) { RlvLevelView view = RLV_LEVEL_VIEW_INIT; return rlv_level_set_view((RlvLevel){id}, &view); }
static RlvResult edit_level(uint64_t id) { RlvLevelEdit edit = RLV_LEVEL_EDIT_INIT; return rlv_level_edit((RlvLevel){id}, &edit, NULL); }
static RlvResult sculpt_level(uint64_t id) { RlvStrokePoint point = {{0.0}, 1.0, -1.0}; return rlv_level_sculpt((RlvLevel){id}, (RlvBrush){0}, &point, 1, 0, NULL); }
static RlvResult undo_level(uint64_t id) { return rlv_level_undo((RlvLevel){id}); }
static RlvResult redo_level(uint64_t id) { return rlv_level_redo((RlvLevel){id}); }
static RlvResult add_motion(uint64_t id) { RlvLevelMotion motion = RLV_LEVEL_MOTION_INIT; return rlv_level_add_motion((RlvLevel){id}, &motion); }
static RlvResult set_time(uint64_t id) { return rlv_level_set_time((RlvLevel){id}, 0.0, NULL); }
static RlvResult clear_motions(uint64_t id) { return rlv_level_clear_motions((RlvLevel){id}); }
static RlvResult misplaced(uint64_t id) { size_t count; return rlv_level_misplaced((RlvLevel){id}, NULL, 0, &count); }
static RlvResult rebuild(uint64_t id) { RlvProgressive out; return rlv_level_rebuild((RlvLevel){id}, NULL, NULL, NULL, &out); }
static RlvResult open_journal(uint64_t id) { return rlv_level_open_journal((RlvLevel){id}, NULL); }
static RlvResult sync_journal(uint64_t id) { return rlv_level_sync_journal((RlvLevel){id}); }
static RlvResult close_journal(uint64_t id) { return rlv_level_close_journal((RlvLevel){id}); }
static RlvResult update_level(uint64_t id) { RlvLevelBuffers room = RLV_LEVEL_BUFFERS_INIT; return rlv_level_update((RlvLevel){id}, &room, NULL); }
static RlvResult level_ranges(uint64_t id) { size_t count; return rlv_level_changed_ranges((RlvLevel){id}, RLV_DOMAIN_POINT, NULL, 0, &count); }
static RlvResult level_mesh(uint64_t id) { RlvMesh out; return rlv_level_mesh((RlvLevel){id}, &out); }
static RlvResult settle_level(uint64_t id) { RlvProgressive out; return rlv_level_settle((RlvLevel){id}, &out); }
static RlvResult evaluate(uint64_t id) { RlvProceduralHits hits = RLV_PROCEDURAL_HITS_INIT; return rlv_procedural_evaluate((RlvProcedural){id}, &hits); }
static RlvResult wait_vulkan(uint64_t id) { return rlv_vulkan_wait((RlvContext){id}, 8, 1); }
static RlvResult signal_vulkan(uint64_t id) { return rlv_vulkan_signal((RlvContext){id}, 8, 1); }
static RlvResult update_colors(uint64_t id) { return rlv_color_buffer_update((RlvColorBuffer){id}, NULL); }
static RlvResult release_colors(uint64_t id) { return rlv_color_buffer_release((RlvColorBuffer){id}); }
static RlvResult read_colors(uint64_t id) { size_t size; return rlv_color_buffer_read((RlvColorBuffer){id}, 0, 0, NULL, 0, &size); }
static RlvResult vulkan_colors(uint64_t id) { RlvColorBufferVulkan out = RLV_COLOR_BUFFER_VULKAN_INIT; return rlv_color_buffer_vulkan((RlvColorBuffer){id}, &out); }
static RlvResult undo_on_device(uint64_t id) { return rlv_device_level_undo((RlvDeviceLevel){id}); }
static RlvResult release_on_device(uint64_t id) { return rlv_device_level_release((RlvDeviceLevel){id}); }
static RlvResult read_on_device(uint64_t id) { RlvLevelBuffers room = RLV_LEVEL_BUFFERS_INIT; return rlv_device_level_read((RlvDeviceLevel){id}, &room, NULL); }
static RlvResult vulkan_on_device(uint64_t id) { RlvDeviceLevelVulkan out = RLV_DEVICE_LEVEL_VULKAN_INIT; return rlv_device_level_vulkan((RlvDeviceLevel){id}, &out); }

/* The nouns whose handles a function takes. */
enum { CONTEXT, MESH, DETAIL, DOCUMENT, PICTURE, PROCEDURAL, JOB, BEZIER, BUFFER, COLORS, PROGRESSIVE, LEVEL, ON_DEVICE, NOUNS };

static const HandleFunction FUNCTIONS[] = {
    {count_layers, DETAIL},       {layer_info, DETAIL},          {add_layer, DETAIL},           {set_layer, DETAIL},
    {activate, DETAIL},           {rename_layer, DETAIL},        {place_layer, DETAIL},         {remove_layer, DETAIL},
    {merge_layer, DETAIL},        {flatten, DETAIL},             {create_document, DETAIL},     {open_document, DETAIL},
    {retain_document, DOCUMENT},  {release_document, DOCUMENT},  {document_info, DOCUMENT},     {begin, DOCUMENT},
    {end, DOCUMENT},              {abandon, DOCUMENT},           {undo, DOCUMENT},              {redo, DOCUMENT},
    {save, DOCUMENT},             {sync_document, DOCUMENT},     {compact, CONTEXT},            {document_mesh, CONTEXT},
    {wait_vulkan, CONTEXT},       {signal_vulkan, CONTEXT},
    {open_bytes, DETAIL},          {save_bytes, DOCUMENT},        {mesh_of_bytes, CONTEXT},
    {transfer, CONTEXT},          {open_picture, CONTEXT},       {retain_picture, PICTURE},     {release_picture, PICTURE},
    {picture_info, PICTURE},      {picture_image, PICTURE},      {picture_meta, PICTURE},       {read_picture, PICTURE},
    {create_procedural, DETAIL},  {create_moving, PROCEDURAL},   {retain_procedural, PROCEDURAL},
    {release_procedural, PROCEDURAL}, {procedural_info, PROCEDURAL}, {procedural_table, PROCEDURAL}, {evaluate, PROCEDURAL},
    {job_tessellate, DETAIL},     {job_bake, DETAIL},            {job_ptex_write, DETAIL},      {job_ptex_read, DETAIL},
    {job_transfer, CONTEXT},      {retain_job, JOB},             {release_job, JOB},            {poll_job, JOB},
    {wait_job, JOB},              {cancel_job, JOB},             {job_result, JOB},             {job_mesh, JOB},
    {job_report, JOB},            {read_bezier, CONTEXT},        {retain_bezier, BEZIER},       {release_bezier, BEZIER},
    {bezier_info, BEZIER},        {bezier_controls, BEZIER},     {evaluate_bezier, BEZIER},     {bezier_levels, BEZIER},
    {count_bezier, BEZIER},       {bezier_mesh, BEZIER},         {update_buffer, BUFFER},       {release_buffer, BUFFER},
    {read_buffer, BUFFER},        {vulkan_buffer, BUFFER},       {build_progressive, MESH},    {job_progressive, MESH},
    {job_progressive_mesh, JOB},  {read_progressive, CONTEXT},   {write_progressive, PROGRESSIVE},
    {retain_progressive, PROGRESSIVE}, {release_progressive, PROGRESSIVE}, {progressive_info, PROGRESSIVE},
    {create_level, PROGRESSIVE},  {retain_level, LEVEL},         {release_level, LEVEL},       {level_info, LEVEL},
    {level_bound, LEVEL},
    {level_error, LEVEL},         {level_triangles, LEVEL},      {level_view, LEVEL},          {edit_level, LEVEL},
    {undo_level, LEVEL},          {redo_level, LEVEL},           {update_level, LEVEL},        {level_mesh, LEVEL},
    {level_ranges, LEVEL},
    {settle_level, LEVEL},        {update_colors, COLORS},       {release_colors, COLORS},      {read_colors, COLORS},
    {undo_on_device, ON_DEVICE},  {release_on_device, ON_DEVICE}, {read_on_device, ON_DEVICE},  {vulkan_on_device, ON_DEVICE},
    {vulkan_colors, COLORS},      {simplify_mesh, MESH},         {sculpt_level, LEVEL},
    {job_simplify, MESH},         {job_simplify_error, JOB},
    {open_journal, LEVEL},        {sync_journal, LEVEL},         {close_journal, LEVEL},
    {take_up, LEVEL},             {misplaced, LEVEL},           {rebuild, LEVEL},              {add_motion, LEVEL},          {set_time, LEVEL},
    {clear_motions, LEVEL},
};

/* What is garbage to one host is another's object: all that is there. */
typedef struct Objects {
    RlvDetail detail;
    RlvDocument document;
    RlvPicture picture;
    RlvProcedural procedural;
    RlvJob job;
    RlvBezier bezier;
    RlvProgressive progressive;
    RlvLevel level;
    char path[64];
} Objects;

static Objects make(RlvContext context, uint32_t kind, const char *name) {
    Objects made;
    RlvSurface surface = RLV_NULL;
    RlvSurfaceOptions how = RLV_SURFACE_OPTIONS_INIT;
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvDocument file = RLV_NULL;
    RlvMesh plane = check_plane(context, 3, 3);
    memset(&made, 0, sizeof made);
    snprintf(made.path, sizeof made.path, "garbage-%s-%p.relievo", name, (void *)&made);
    how.kind = kind;
    options.tile_size = 16;
    CHECK_OK(rlv_surface_create(context, plane, &how, &surface));
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &made.detail));
    CHECK_OK(rlv_detail_add_paint(made.detail, NULL));
    check_stroke(context, made.detail, RLV_BRUSH_SCULPT, 1.8, 1.6, 0.6f);
    CHECK_OK(rlv_detail_commit(made.detail, NULL));
    CHECK_OK(rlv_document_create(made.detail, made.path, 0, &file));
    CHECK_OK(rlv_document_release(file));
    CHECK_OK(rlv_document_create(made.detail, NULL, 0, &made.document));
    CHECK_OK(rlv_picture_open(context, made.path, &made.picture));
    CHECK_OK(rlv_procedural_create(made.detail, NULL, &made.procedural));
    CHECK_OK(rlv_job_tessellate(made.detail, NULL, &made.job));
    CHECK_OK(rlv_job_wait(made.job, -1.0, NULL));
    RlvBezierArrays arrays = RLV_BEZIER_ARRAYS_INIT;
    float points[16][3];
    for (int k = 0; k < 16; ++k) {
        points[k][0] = (float)(k % 4), points[k][1] = (float)(k / 4), points[k][2] = 0.0f;
    }
    arrays.points = points[0];
    arrays.point_count = 16;
    CHECK_OK(rlv_bezier_create(context, &arrays, &made.bezier));
    CHECK_OK(rlv_progressive_create(plane, NULL, NULL, NULL, &made.progressive));
    CHECK_OK(rlv_level_create(made.progressive, &made.level));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    return made;
}

static void release(Objects objects) {
    CHECK_OK(rlv_document_release(objects.document));
    CHECK_OK(rlv_picture_release(objects.picture));
    CHECK_OK(rlv_procedural_release(objects.procedural));
    CHECK_OK(rlv_job_release(objects.job));
    CHECK_OK(rlv_bezier_release(objects.bezier));
    CHECK_OK(rlv_level_release(objects.level));
    CHECK_OK(rlv_progressive_release(objects.progressive));
    CHECK_OK(rlv_detail_release(objects.detail));
    remove(objects.path);
}

static void check_handles(RlvContext context, Objects objects) {
    const Objects dead = make(context, RLV_SURFACE_CATMULL_CLARK, "dead");
    release(dead);
    /* Some need a device; c_buffer, c_color_buffer and c_device_level have them. */
    const uint64_t alive[NOUNS] = {context.id, 0, objects.detail.id, objects.document.id, objects.picture.id, objects.procedural.id,
                                   objects.job.id, objects.bezier.id, 0, 0, objects.progressive.id, objects.level.id, 0};
    const uint64_t others[] = {0, 1, UINT64_MAX, dead.detail.id, dead.document.id, dead.picture.id, dead.procedural.id,
                               dead.job.id, dead.bezier.id, dead.progressive.id, dead.level.id,
                               objects.detail.id ^ (UINT64_C(1) << 40), objects.picture.id + 1};
    for (size_t k = 0; k < sizeof FUNCTIONS / sizeof *FUNCTIONS; ++k) {
        check_handle_function(FUNCTIONS[k], alive, NOUNS, others, sizeof others / sizeof *others);
    }
}

static void check_null(RlvContext context, Objects objects) {
    RlvLayerOptions layer = RLV_LAYER_OPTIONS_INIT;
    RlvDocument document;
    RlvPicture picture;
    RlvProcedural procedural;
    const float uv[2] = {0.5f, 0.25f};
    const uint32_t first = 0;
    uint32_t id;
    RlvProceduralHits hits = RLV_PROCEDURAL_HITS_INIT;
    const RlvDetail detail = objects.detail;
    CHECK(rlv_layer_count(detail, NULL) == RLV_ERROR_INVALID && rlv_layer_info(detail, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_layer_add(detail, NULL, &layer, &id) == RLV_ERROR_INVALID);
    CHECK(rlv_layer_add(detail, "a", NULL, &id) == RLV_ERROR_INVALID);
    CHECK(rlv_layer_add(detail, "\xff", &layer, &id) == RLV_ERROR_INVALID && rlv_layer_add(detail, "", &layer, &id) == RLV_ERROR_INVALID);
    CHECK(rlv_layer_set(detail, 0, NULL) == RLV_ERROR_INVALID && rlv_layer_rename(detail, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_document_create(detail, NULL, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_document_open(detail, NULL, 0, &document) == RLV_ERROR_INVALID);
    CHECK(rlv_document_open(detail, objects.path, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_document_info(objects.document, NULL) == RLV_ERROR_INVALID && rlv_document_save(objects.document, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_document_compact(context, NULL, 0) == RLV_ERROR_INVALID && rlv_document_mesh(context, objects.path, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_document_begin(objects.document, "\xc3\x28") == RLV_ERROR_INVALID);
    CHECK(rlv_picture_open(context, NULL, &picture) == RLV_ERROR_INVALID && rlv_picture_open(context, objects.path, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_picture_info(objects.picture, NULL) == RLV_ERROR_INVALID && rlv_picture_image(objects.picture, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_picture_meta(objects.picture, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_picture_read(objects.picture, 0, 0, 0, 0, 1, 1, NULL, 0) == RLV_ERROR_INVALID);
    CHECK(rlv_procedural_create(detail, NULL, NULL) == RLV_ERROR_INVALID && rlv_procedural_evaluate(objects.procedural, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_procedural_create_moving(objects.procedural, detail, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_procedural_info(objects.procedural, NULL) == RLV_ERROR_INVALID && rlv_procedural_table(objects.procedural, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_procedural_create_moving(objects.procedural, (RlvDetail)RLV_NULL, &procedural) == RLV_ERROR_INVALID);
    RlvJob job;
    RlvBezier bezier;
    RlvBezierArrays arrays = RLV_BEZIER_ARRAYS_INIT;
    RlvBuffer buffer;
    RlvColorBuffer colors;
    RlvDeviceLevel on_device;
    RlvTessellation triangles = RLV_NULL;
    uint32_t level;
    RlvProgressive progressive;
    RlvMesh mesh;
    RlvLevelBuffers room = RLV_LEVEL_BUFFERS_INIT;
    RlvLevelEdit edit = RLV_LEVEL_EDIT_INIT;
    CHECK(rlv_job_tessellate(detail, NULL, NULL) == RLV_ERROR_INVALID && rlv_job_bake(detail, NULL, NULL, &job) == RLV_ERROR_INVALID);
    CHECK(rlv_job_ptex_read(detail, NULL, NULL, &job) == RLV_ERROR_INVALID && rlv_job_ptex_write(detail, 0, NULL, &job) == RLV_ERROR_INVALID);
    CHECK(rlv_job_ptex_write(detail, 0, "garbage.ptx", NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_job_mesh(objects.job, NULL) == RLV_ERROR_INVALID && rlv_job_imprint_report(objects.job, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_bezier_create(context, NULL, &bezier) == RLV_ERROR_INVALID && rlv_bezier_create(context, &arrays, &bezier) == RLV_ERROR_INVALID);
    arrays.point_count = 16;
    CHECK(rlv_bezier_create(context, &arrays, &bezier) == RLV_ERROR_INVALID);
    arrays.point_count = SIZE_MAX;
    arrays.points = uv;
    CHECK(rlv_bezier_create(context, &arrays, &bezier) == RLV_ERROR_INVALID);
    CHECK(rlv_bezier_read(context, NULL, &bezier) == RLV_ERROR_INVALID && rlv_bezier_read(context, objects.path, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_bezier_info(objects.bezier, NULL) == RLV_ERROR_INVALID && rlv_bezier_get_controls(objects.bezier, 0, NULL, 0) == RLV_ERROR_INVALID);
    CHECK(rlv_bezier_get_controls(objects.bezier, 1, (float[64]){0}, 0) == RLV_ERROR_INVALID);
    CHECK(rlv_bezier_evaluate(objects.bezier, NULL) == RLV_ERROR_INVALID && rlv_bezier_mesh(objects.bezier, NULL, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_bezier_levels(objects.bezier, NULL, &level, 1) == RLV_ERROR_INVALID);
    CHECK(rlv_bezier_tessellate(objects.bezier, NULL, NULL) == RLV_ERROR_INVALID);
    RlvSimplifyOptions simple = RLV_SIMPLIFY_OPTIONS_INIT;
    RlvMesh flat = check_plane(context, 3, 3);
    CHECK(rlv_simplify_mesh(flat, NULL, NULL, NULL, NULL, NULL) == RLV_ERROR_INVALID);
    simple.weight_count = 1;
    CHECK(rlv_simplify_mesh(flat, &simple, NULL, NULL, NULL, &mesh) == RLV_ERROR_INVALID);
    simple.weights = &(RlvSimplifyWeight){NULL, 0.0f, 0};
    CHECK(rlv_simplify_mesh(flat, &simple, NULL, NULL, NULL, &mesh) == RLV_ERROR_INVALID);
    simple.weight_count = 0;
    simple.factor_count = SIZE_MAX;
    simple.factors = (const float *)uv;
    CHECK(rlv_simplify_mesh(flat, &simple, NULL, NULL, NULL, &mesh) == RLV_ERROR_INVALID);
    CHECK_OK(rlv_mesh_release(flat));
    CHECK(rlv_progressive_read(context, NULL, 1, &progressive) == RLV_ERROR_INVALID && rlv_progressive_read(context, objects.path, 1, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_progressive_write(objects.progressive, "\xff") == RLV_ERROR_INVALID && rlv_progressive_info(objects.progressive, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_progressive_read(context, objects.path, SIZE_MAX, &progressive) == RLV_ERROR_INVALID);
    CHECK(rlv_level_create(objects.progressive, NULL) == RLV_ERROR_INVALID && rlv_level_info(objects.level, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_level_set_view(objects.level, NULL) == RLV_ERROR_INVALID && rlv_level_edit(objects.level, NULL, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_level_update(objects.level, NULL, NULL) == RLV_ERROR_INVALID && rlv_level_update(objects.level, &room, NULL) == RLV_ERROR_INVALID);
    room.vertex_capacity = room.triangle_capacity = SIZE_MAX;
    CHECK(rlv_level_update(objects.level, &room, NULL) == RLV_ERROR_INVALID);
    room.points = (float *)uv;
    CHECK(rlv_level_update(objects.level, &room, NULL) == RLV_ERROR_INVALID);
    edit.handle_count = SIZE_MAX;
    CHECK(rlv_level_edit(objects.level, &edit, NULL) == RLV_ERROR_INVALID);
    RlvBrush brush;
    RlvBrushOptions sculpting = RLV_BRUSH_OPTIONS_INIT;
    const RlvStrokePoint point = {{0.0}, 1.0, -1.0};
    sculpting.action = RLV_BRUSH_SCULPT;
    CHECK_OK(rlv_brush_create(context, &sculpting, NULL, &brush));
    CHECK(rlv_level_sculpt(objects.level, (RlvBrush){objects.level.id}, &point, 1, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_level_sculpt(objects.level, brush, NULL, 1, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_level_sculpt(objects.level, brush, &point, SIZE_MAX, 0, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_level_sculpt(objects.level, brush, &point, 1, 3, NULL) == RLV_ERROR_INVALID);
    CHECK_OK(rlv_brush_release(brush));
    CHECK(rlv_level_mesh(objects.level, NULL) == RLV_ERROR_INVALID && rlv_level_settle(objects.level, NULL) == RLV_ERROR_INVALID);
    CHECK_OK(rlv_level_mesh(objects.level, &mesh));
    CHECK_OK(rlv_mesh_release(mesh));
    /* The context has no device. */
    CHECK_OK(rlv_tessellation_create(detail, NULL, &triangles));
    CHECK(rlv_buffer_create(triangles, &buffer) == RLV_ERROR_UNSUPPORTED && rlv_buffer_create(triangles, NULL) == RLV_ERROR_INVALID);
    CHECK_OK(rlv_tessellation_release(triangles));
    CHECK(rlv_color_buffer_create(detail, &colors) == RLV_ERROR_UNSUPPORTED && rlv_color_buffer_create(detail, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_device_level_create(objects.progressive, &on_device) == RLV_ERROR_UNSUPPORTED);
    CHECK(rlv_device_level_create(objects.progressive, NULL) == RLV_ERROR_INVALID);
    CHECK(rlv_adapter_list(NULL, 0, NULL) == RLV_ERROR_INVALID);
    hits.count = 1;
    hits.uvs = uv;
    CHECK(rlv_procedural_evaluate(objects.procedural, &hits) == RLV_ERROR_INVALID);
    hits.primitives = &first;
    hits.uvs = NULL;
    CHECK(rlv_procedural_evaluate(objects.procedural, &hits) == RLV_ERROR_INVALID);
    /* Nothing wanted is nothing written. */
    hits.uvs = uv;
    CHECK_OK(rlv_procedural_evaluate(objects.procedural, &hits));
    hits.count = SIZE_MAX;
    CHECK(rlv_procedural_evaluate(objects.procedural, &hits) == RLV_ERROR_INVALID);
}

static void check_sizes(RlvContext context, Objects objects) {
    const uint32_t wrong[] = {0, 3, 65537, UINT32_MAX};
    for (size_t k = 0; k < sizeof wrong / sizeof *wrong; ++k) {
        RlvLayerOptions layer = RLV_LAYER_OPTIONS_INIT;
        RlvLayerInfo layer_info_out = RLV_LAYER_INFO_INIT;
        RlvDocumentInfo document = RLV_DOCUMENT_INFO_INIT;
        RlvDocumentChanges changes = RLV_DOCUMENT_CHANGES_INIT;
        RlvTransferOptions options = RLV_TRANSFER_OPTIONS_INIT;
        RlvPictureInfo picture = RLV_PICTURE_INFO_INIT;
        RlvPictureImage image = RLV_PICTURE_IMAGE_INIT;
        RlvPictureMeta meta = RLV_PICTURE_META_INIT;
        RlvProceduralOptions cells = RLV_PROCEDURAL_OPTIONS_INIT;
        RlvProceduralInfo about = RLV_PROCEDURAL_INFO_INIT;
        RlvProceduralTable table = RLV_PROCEDURAL_TABLE_INIT;
        RlvProceduralHits hits = RLV_PROCEDURAL_HITS_INIT;
        RlvProcedural none = RLV_NULL;
        uint32_t id = 0;
        layer.struct_size = layer_info_out.struct_size = document.struct_size = changes.struct_size = wrong[k];
        options.struct_size = picture.struct_size = image.struct_size = meta.struct_size = wrong[k];
        cells.struct_size = about.struct_size = table.struct_size = hits.struct_size = wrong[k];
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_add(objects.detail, "a", &layer, &id), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_set(objects.detail, 0, &layer), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_layer_info(objects.detail, 0, &layer_info_out), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_info(objects.document, &document), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_undo(objects.document, &changes), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_transfer(context, (RlvMesh)RLV_NULL, objects.path, "b.relievo", &options, NULL, NULL, NULL), "");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_info(objects.picture, &picture), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_image(objects.picture, 0, &image), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_picture_meta(objects.picture, 0, &meta), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_create(objects.detail, &cells, &none), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_info(objects.procedural, &about), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_table(objects.procedural, &table), "struct_size");
        CHECK_FAILS(RLV_ERROR_INVALID, rlv_procedural_evaluate(objects.procedural, &hits), "struct_size");
        CHECK(none.id == 0 && id == 0);
    }
}

static void check_numbers(Objects objects) {
    const float bad[] = {NAN, INFINITY, -INFINITY, -1.0f, 2.0f};
    for (size_t k = 0; k < sizeof bad / sizeof *bad; ++k) {
        RlvLayerOptions layer = RLV_LAYER_OPTIONS_INIT;
        RlvProceduralHits hits = RLV_PROCEDURAL_HITS_INIT;
        const uint32_t first = 0;
        const float uv[2] = {0.25f, bad[k]}, good[2] = {0.25f, 0.25f};
        float position[3] = {7, 7, 7};
        uint32_t id = 0;
        layer.opacity = bad[k];
        CHECK(rlv_layer_add(objects.detail, "a", &layer, &id) == RLV_ERROR_INVALID && id == 0);
        hits.count = 1;
        hits.primitives = &first;
        hits.uvs = uv;
        hits.positions = position;
        CHECK(rlv_procedural_evaluate(objects.procedural, &hits) == RLV_ERROR_INVALID && position[0] == 7);
        /* Times are held within the interval. */
        hits.uvs = good;
        hits.times = &bad[k];
        CHECK_OK(rlv_procedural_evaluate(objects.procedural, &hits));
        CHECK(isfinite(position[0]) && position[0] != 7);
    }
    const uint32_t cells[] = {1, 2, 3, 5, 513, 1024, UINT32_MAX};
    for (size_t k = 0; k < sizeof cells / sizeof *cells; ++k) {
        RlvProceduralOptions options = RLV_PROCEDURAL_OPTIONS_INIT;
        RlvProcedural none = RLV_NULL;
        options.coarse = cells[k];
        CHECK(rlv_procedural_create(objects.detail, &options, &none) == RLV_ERROR_INVALID && none.id == 0);
    }
    RlvLayerOptions layer = RLV_LAYER_OPTIONS_INIT;
    uint32_t id = 0;
    layer.tile_size = 9;
    CHECK(rlv_layer_add(objects.detail, "a", &layer, &id) == RLV_ERROR_INVALID);
    layer.tile_size = 16;
    layer.kind = 77;
    CHECK(rlv_layer_add(objects.detail, "a", &layer, &id) == RLV_ERROR_INVALID);
    layer.kind = RLV_LAYER_DISPLACEMENT;
    layer.blend = 77;
    CHECK(rlv_layer_add(objects.detail, "a", &layer, &id) == RLV_ERROR_INVALID && id == 0);
}

/* Whatever a renderer hands to the functions of the table. */
static void check_table(Objects objects) {
    RlvProceduralTable table = RLV_PROCEDURAL_TABLE_INIT;
    const float bad[] = {NAN, INFINITY, -INFINITY, 0.0f, 1e38f, -1e-40f};
    float box[8], rays[40];
    int32_t valid[2] = {-1, 0};
    CHECK_OK(rlv_procedural_table(objects.procedural, &table));
    for (uint32_t k = 0; k < 6 * 9; ++k) {
        memset(rays, 0, sizeof rays);
        rays[0] = rays[2] = 1.5f, rays[4] = 3.0f, rays[12] = -1.0f, rays[16] = INFINITY;
        rays[2 * (k / 6)] = bad[k % 6];
        for (uint32_t primitive = 0; primitive < 4; ++primitive) {
            const uint32_t which = primitive < 2 ? primitive : primitive == 2 ? table.primitive_count : UINT32_MAX;
            table.intersect(table.data, valid, which, 0, 0, rays, 2);
            table.occluded(table.data, valid, which, rays, 2);
            table.bounds(table.data, which, primitive, box);
        }
        CHECK(rays[1] == 0.0f && rays[17] == 0.0f); /* the ray that is off */
    }
    table.intersect(NULL, valid, 0, 0, 0, rays, 1);
    table.intersect(table.data, NULL, 0, 0, 0, rays, 1);
    table.intersect(table.data, valid, 0, 0, 0, NULL, 1);
    table.occluded(table.data, NULL, 0, rays, 1);
    table.bounds(table.data, 0, 0, NULL);
}

enum { ROUNDS = 12 };

/* Edits a document and its layers as if it were alone. */
static void *edit(void *user) {
    const Objects *objects = user;
    for (int round = 0; round < ROUNDS; ++round) {
        RlvLayerOptions options = RLV_LAYER_OPTIONS_INIT;
        char name[32];
        uint32_t id = 0;
        RlvResult results[8];
        snprintf(name, sizeof name, "%p %d", (void *)&options, round);
        options.tile_size = 16;
        results[0] = rlv_document_begin(objects->document, name);
        results[1] = rlv_layer_add(objects->detail, name, &options, &id);
        results[2] = rlv_layer_set_active(objects->detail, id);
        results[3] = round % 3 ? rlv_document_end(objects->document, NULL) : rlv_document_abandon(objects->document);
        results[4] = rlv_document_undo(objects->document, NULL);
        results[5] = rlv_document_redo(objects->document, NULL);
        results[6] = rlv_layer_remove(objects->detail, id);
        results[7] = rlv_detail_commit(objects->detail, NULL);
        for (int k = 0; k < 8; ++k) {
            CHECK(results[k] == RLV_OK || results[k] == RLV_ERROR_BUSY || results[k] == RLV_ERROR_INVALID);
        }
    }
    return NULL;
}

/* Reads meanwhile. */
static void *look(void *user) {
    const Objects *objects = user;
    for (int round = 0; round < ROUNDS; ++round) {
        RlvProceduralHits hits = RLV_PROCEDURAL_HITS_INIT;
        RlvProcedural own = RLV_NULL;
        const uint32_t first = 0;
        const float uv[2] = {0.25f, 0.25f};
        float position[3], pixel[4];
        size_t count = 0;
        hits.count = 1;
        hits.primitives = &first;
        hits.uvs = uv;
        hits.positions = position;
        CHECK_OK(rlv_procedural_evaluate(objects->procedural, &hits));
        CHECK_OK(rlv_picture_read(objects->picture, 0, 0, 5, 5, 1, 1, pixel, 0));
        CHECK_OK(rlv_procedural_create(objects->detail, NULL, &own));
        CHECK_OK(rlv_procedural_release(own));
        const RlvResult result = rlv_layer_count(objects->detail, &count);
        CHECK((result == RLV_OK && count > 0) || result == RLV_ERROR_BUSY);
    }
    return NULL;
}

static void check_threads(Objects objects) {
    pthread_t threads[4];
    for (int k = 0; k < 4; ++k) {
        CHECK(pthread_create(&threads[k], NULL, k < 2 ? edit : look, &objects) == 0);
    }
    for (int k = 0; k < 4; ++k) {
        CHECK(pthread_join(threads[k], NULL) == 0);
    }
    /* It can be used as before. */
    const RlvResult result = rlv_document_abandon(objects.document);
    CHECK(result == RLV_OK || result == RLV_ERROR_INVALID);
    CHECK_OK(rlv_detail_commit(objects.detail, NULL));
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.threads = 2;
    CHECK_OK(rlv_context_create(&options, &context));
    const uint32_t kinds[2] = {RLV_SURFACE_CATMULL_CLARK, RLV_SURFACE_TRIANGLES};
    for (int k = 0; k < 2; ++k) {
        const Objects objects = make(context, kinds[k], k ? "triangles" : "tiles");
        check_handles(context, objects);
        check_null(context, objects);
        check_sizes(context, objects);
        check_numbers(objects);
        check_table(objects);
        check_threads(objects);
        release(objects);
    }
    CHECK_OK(rlv_context_release(context));
    return 0;
}
