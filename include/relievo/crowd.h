/* Relievo: crowds of articulated models, each drawn with as many triangles as its pixels deserve in its pose.
 *
 * A crowd model is a character or a static model with a hierarchy of clusters of triangles (View-Dependent Representation
 * of Articulated Models, Journal of WSCG 21, 2013). The error of a cluster is a distance that is measured in every pose of
 * the clips. A crowd places agents, and a view cuts it: for every agent it finds the clusters whose error it cannot see,
 * without cracks between them. The host draws the clusters from its own buffers: vertices and triangles once for each
 * model, and for each frame the arguments of indexed draws, the instances, and the skin matrices.
 *
 * Lengths are in units of the model or of the world, times in seconds. Results do not depend on the number of threads. */
#ifndef RELIEVO_CROWD_H
#define RELIEVO_CROWD_H

#include "relievo/bytes.h"
#include "relievo/mesh.h"
#include "relievo/parameter.h"

typedef struct RlvCrowdModel {
    uint64_t id;
} RlvCrowdModel;

typedef struct RlvCrowd {
    uint64_t id;
} RlvCrowd;

/* How the maps of several bones are blended. With either the matrices of a frame are those of single bones. The shader of a host
 * that blends dual quaternions reads RlvCrowdBuffers::dual_rows in their place. For a vertex with up to four bones it
 * 1. adds the rows of stretch of the bones, each times its weight;
 * 2. adds the rotations and the dual parts of the bones, each times its weight, or times minus its weight where the dot product
 *    of its rotation and that of the first bone with the largest weight is below 0;
 * 3. divides both sums by the length of that of the rotations, which gives r and d;
 * 4. moves the vertex to the vector part of r * (stretch * place) * conjugate(r) + 2 * d * conjugate(r), by products of
 *    quaternions, and turns its normal by r * (inverse transpose of stretch * normal) * conjugate(r). */
typedef enum RlvCrowdBlend {
    RLV_CROWD_BLEND_LINEAR = 0,         /* weighted sums of matrices */
    RLV_CROWD_BLEND_DUAL_QUATERNION = 1 /* weighted sums of dual quaternions, which keep the volume of twisted joints; scale and
                                           shear are blended linearly before the rigid part */
} RlvCrowdBlend;

/* How a hierarchy is built. rlv_crowd_params has ranges, units and defaults of every field. */
typedef struct RlvCrowdBuildSettings {
    uint32_t struct_size;
    float pose_distance;        /* distance of poses that are taken as alike, as a share of the diagonal of the model's box */
    uint32_t cluster_triangles; /* triangles of a cluster at most */
    uint32_t group_clusters;    /* clusters that are simplified together at most; an eighth of the input's clusters if that is less, but four */
    float pose_rate;            /* poses that are sampled for each second of a clip, 1/s */
} RlvCrowdBuildSettings;

#define RLV_CROWD_BUILD_SETTINGS_INIT {sizeof(RlvCrowdBuildSettings), 0.15f, 100, 16, 30.0f}

/* The name of a clip, or its number from 0 as text. */
typedef struct RlvCrowdClipName {
    const char *name;
} RlvCrowdClipName;

/* What a refit changed. */
typedef struct RlvCrowdRefitReport {
    uint32_t struct_size;
    uint32_t grown_groups;   /* groups whose simplification has a larger error than before */
    double growth;           /* triangles of a cut after the refit over those before, at equal errors: the largest of four cuts */
    uint32_t is_rebuild_due; /* 1: growth is 1.5 or more, and a new build would draw fewer triangles; 0: it is less */
    uint32_t reserved;
} RlvCrowdRefitReport;

#define RLV_CROWD_REFIT_REPORT_INIT {sizeof(RlvCrowdRefitReport), 0, 0.0, 0, 0}

/* Counts and bounds of a model. */
typedef struct RlvCrowdModelInfo {
    uint32_t struct_size;
    uint32_t vertex_count;
    uint32_t triangle_count;  /* of all clusters */
    uint32_t input_triangles; /* of the clusters of the input */
    uint32_t cluster_count;
    uint32_t group_count;     /* of clusters that were simplified together */
    uint32_t bone_count;
    uint32_t clip_count;      /* 1 or more */
    uint32_t material_count;
    uint32_t pose_count;      /* of all clips */
    uint32_t representatives; /* poses that the model was simplified over */
    float largest_error;      /* of the coarsest cut, units of the model */
    uint64_t measured;        /* distances: one for each group in each pose */
    uint64_t exceeded;        /* of these, larger than in every representative pose; the errors hold them */
    float low[3];             /* smallest coordinates in all poses */
    float high[3];            /* largest coordinates in all poses */
    uint32_t morph_count;     /* morph targets that clips move */
    uint32_t offset_count;    /* of vertices by these */
    uint32_t blend;           /* RlvCrowdBlend */
    uint32_t reserved;
} RlvCrowdModelInfo;

#define RLV_CROWD_MODEL_INFO_INIT \
    {sizeof(RlvCrowdModelInfo), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0.0f, 0, 0, {0.0f}, {0.0f}, 0, 0, RLV_CROWD_BLEND_LINEAR, 0}

/* A clip: an animation sampled as poses, which repeats. */
typedef struct RlvCrowdClip {
    uint32_t struct_size;
    uint32_t pose_count;
    float rate; /* poses a second */
    char name[RLV_NAME_SIZE];
} RlvCrowdClip;

#define RLV_CROWD_CLIP_INIT {sizeof(RlvCrowdClip), 0, 0.0f, {0}}

/* The name of a material. */
typedef struct RlvCrowdMaterial {
    uint32_t struct_size;
    char name[RLV_TEXT_SIZE];
} RlvCrowdMaterial;

#define RLV_CROWD_MATERIAL_INIT {sizeof(RlvCrowdMaterial), {0}}

/* Arrays that vertices are written to, packed; NULL leaves an array out. */
typedef struct RlvCrowdVertices {
    uint32_t struct_size;
    uint32_t reserved;
    size_t capacity; /* vertices that each array has room for */
    float *points;   /* three floats, at binding, units of the model */
    float *normals;  /* three floats, at binding */
    float *uvs;      /* two floats */
    uint32_t *bones; /* four of the bones of a pose */
    float *weights;  /* four weights of the bones, which add up to 1 */
} RlvCrowdVertices;

#define RLV_CROWD_VERTICES_INIT {sizeof(RlvCrowdVertices), 0, 0, NULL, NULL, NULL, NULL, NULL}

/* Where a vertex goes when its place is removed: in a draw of a cluster that this group uses (used_by), the vertex is at
 * (1 - blend) of its posed place and blend of that of its target. */
typedef struct RlvCrowdCollapse {
    uint32_t group;  /* UINT32_MAX if no group removes it */
    uint32_t target; /* a vertex */
} RlvCrowdCollapse;

/* What a morph target adds to a vertex at binding, at weight 1. */
typedef struct RlvCrowdOffset {
    uint32_t vertex;
    uint32_t morph;  /* the morph target, below morph_count */
    float offset[3]; /* units of the model */
} RlvCrowdOffset;

/* A cluster: triangles that are drawn together. */
typedef struct RlvCrowdCluster {
    uint32_t first_triangle; /* in the triangles of the model */
    uint32_t triangle_count;
    uint32_t made_by;        /* the group whose simplification made it, UINT32_MAX for clusters of the input */
    uint32_t used_by;        /* the group that it is simplified in, UINT32_MAX for the coarsest */
    uint32_t depth;          /* simplifications below it, 0 for clusters of the input */
    float deformation;       /* largest extent of a vertex's path against its bones, units of the model */
} RlvCrowdCluster;

/* A model placed in the world. */
typedef struct RlvCrowdAgent {
    uint32_t model;       /* of the crowd, from 0 */
    uint32_t clip;        /* of the model, from 0 */
    double phase;         /* seconds that it is ahead in its clip */
    double transform[12]; /* from the model to the world: three columns of the axes, then the translation */
} RlvCrowdAgent;

/* A sun that throws shadows into a view. */
typedef struct RlvCrowdSun {
    double towards[3];     /* direction towards it in the agents' world, of any length above 0 */
    double angular_radius; /* half its angular diameter, radians, 0 or more */
} RlvCrowdSun;

/* From where a crowd is seen, and when. */
typedef struct RlvCrowdView {
    uint32_t struct_size;
    uint32_t width;   /* pixels */
    uint32_t height;  /* pixels */
    float tolerance;  /* error that may be seen, pixels, above 0 */
    double eye[3];    /* place of the camera, in units of the agents' world */
    double target[3]; /* place that is in the middle of the picture, in the same units; other than eye */
    double up[3];     /* direction that is up in the picture, of any length above 0; not along the view */
    double fov;       /* vertical field of view, radians */
    double time;      /* since the clips began, seconds */
    uint32_t occlusion; /* 1 leaves out agents that others hide at the middle of every pixel they may cover; 0 does not */
    uint32_t geomorph;  /* 1 moves vertices from cut to cut as the view moves, so that nothing jumps; 0 does not */
    uint32_t impostors; /* 1 makes agents of a few pixels quads with pictures of them, where these hold the error; 0 does not */
    uint32_t reserved;
    const RlvCrowdSun *suns; /* suns whose shadows the host draws, packed: agents out of sight that may throw shadows into the
                              * view are drawn too, as finely as their distance from the eye asks; may be NULL */
    size_t sun_count;
    double around; /* agents out of sight within so far of the view are drawn too, since they hide a part of the sky; units of the
                    * agents' world, 0 or more */
} RlvCrowdView;

#define RLV_CROWD_VIEW_INIT \
    {sizeof(RlvCrowdView), 0, 0, 0.5f, {0.0}, {0.0, 0.0, -1.0}, {0.0, 1.0, 0.0}, 0.6, 0.0, 0, 0, 0, 0, NULL, 0, 0.0}

/* Counts of a frame. */
typedef struct RlvCrowdFrame {
    uint32_t struct_size;
    uint32_t agent_count;  /* in view, without hidden ones and impostors: instances */
    uint32_t draw_count;
    uint32_t matrix_count; /* one for each bone of each pose that is shown */
    uint32_t changed;      /* agents that show other clusters than in the last frame, or may do so */
    uint32_t hidden;       /* agents in view that others hide, which have no draws */
    uint64_t clusters;     /* of agent_count agents */
    uint64_t triangles;    /* of agent_count agents */
    uint64_t hidden_triangles;   /* of hidden agents and clusters */
    uint64_t occluder_triangles; /* that were drawn into depths to find what is hidden; 0 where that rested */
    uint32_t weight_count;       /* one for each morph target of each pose that is shown */
    uint32_t impostor_count;     /* agents that are quads, of two of the triangles each */
    uint32_t picture_count;      /* of impostors, which share those of equal poses and directions */
    uint32_t hidden_clusters;    /* of agents that others hide in part, which have no draws */
} RlvCrowdFrame;

#define RLV_CROWD_FRAME_INIT {sizeof(RlvCrowdFrame), 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0}

/* Arguments of an indexed draw, in the layout of VkDrawIndexedIndirectCommand. The vertices of all models are in one
 * buffer, one model after the other, and so are the indices of their triangles. */
typedef struct RlvCrowdDraw {
    uint32_t index_count;    /* three for each triangle of a cluster */
    uint32_t instance_count; /* agents that show it */
    uint32_t first_index;    /* in the indices of all models */
    int32_t base_vertex;     /* the first vertex of the model in the vertices of all models */
    uint32_t first_instance;
} RlvCrowdDraw;

/* An agent that is drawn. */
typedef struct RlvCrowdInstance {
    uint32_t agent;
    uint32_t first_matrix; /* of its pose; the bones of the vertices count from there */
    float transform[12];   /* from the model to the world: three rows of four */
} RlvCrowdInstance;

/* Arrays that a frame is written to; NULL leaves an array out. Strides are in bytes, 0 for packed. */
typedef struct RlvCrowdBuffers {
    uint32_t struct_size;
    uint32_t reserved;
    RlvCrowdDraw *draws;
    size_t draw_capacity;
    size_t draw_stride;
    uint32_t *clusters; /* model and cluster of each draw, packed, with room for draw_capacity */
    RlvCrowdInstance *instances;
    size_t instance_capacity;
    size_t instance_stride;
    float *matrices; /* from the vertices at binding to the model: three rows of four floats for each bone of a pose */
    size_t matrix_capacity;
    size_t matrix_stride;
    float *weights; /* of the morph targets of a pose, packed: vertices move by the weighted sum of offsets before bones move them */
    size_t weight_capacity;
    uint32_t *first_weights; /* the first weight of the pose of each instance, packed, with room for instance_capacity */
    float *blends; /* how far the vertices of each draw are on the way to their targets, 0 to 1, packed, with room for draw_capacity */
    float *dual_rows; /* of each matrix, for bones that are blended as dual quaternions: three rows of four floats of its stretch, the
                       * last of them 0, then its rotation and its dual part, quaternions x, y, z, w; packed, with room for
                       * matrix_capacity. They are computed when they are asked for */
} RlvCrowdBuffers;

#define RLV_CROWD_BUFFERS_INIT \
    {sizeof(RlvCrowdBuffers), 0, NULL, 0, 0, NULL, NULL, 0, 0, NULL, 0, 0, NULL, 0, NULL, NULL, NULL}

/* Texels along a side of the picture of an impostor. */
#define RLV_CROWD_PICTURE_SIDE 32

/* An agent that is drawn as a quad: the square of its picture. */
typedef struct RlvCrowdImpostor {
    uint32_t agent;
    uint32_t picture;    /* in the pictures of the frame */
    float transform[12]; /* from the model to the world: three rows of four */
} RlvCrowdImpostor;

/* A picture of a model in a pose, on a square in the space of the model: center + x * axes[0] + y * axes[1], where x and y
 * go from -radius to radius. */
typedef struct RlvCrowdPicture {
    uint64_t number;  /* of all that were made: hosts keep what they made of it for later frames */
    uint32_t model;
    float radius;     /* half a side of the square, units of the model */
    float center[3];  /* of the square, units of the model */
    float axes[9];    /* to the right, up and towards the viewer, of length 1 */
} RlvCrowdPicture;

/* What a picture shows at a texel. */
typedef struct RlvCrowdTexel {
    uint32_t cluster; /* UINT32_MAX where there is nothing */
    uint32_t material;
    float normal[3];  /* in the space of the model, of length 1 */
} RlvCrowdTexel;

/* Arrays that the impostors of a frame are written to; NULL leaves an array out. Strides are in bytes, 0 for packed. */
typedef struct RlvCrowdImpostors {
    uint32_t struct_size;
    uint32_t reserved;
    RlvCrowdImpostor *impostors;
    size_t impostor_capacity;
    size_t impostor_stride;
    RlvCrowdPicture *pictures;
    size_t picture_capacity;
    size_t picture_stride;
    RlvCrowdTexel *texels; /* of one picture after the other, packed: RLV_CROWD_PICTURE_SIDE rows of as many, the lowest first */
    size_t texel_capacity;
} RlvCrowdImpostors;

#define RLV_CROWD_IMPOSTORS_INIT {sizeof(RlvCrowdImpostors), 0, NULL, 0, 0, NULL, 0, 0, NULL, 0}

/* The fields of RlvCrowdBuildSettings in order: a table that lives as long as the process, and its length. No failure of
 * its own. */
RLV_API RlvResult rlv_crowd_params(const RlvParameter **params, size_t *count);

/* Builds the hierarchy of all that a file of glTF, USD, OBJ, PLY, STL or OFF shows, for clip_count of its clips; without
 * clips for all of the file. Settings may be NULL for the defaults, and progress NULL. Fails if the file cannot be read or
 * has no triangles, a clip does not exist, a number is out of range, or progress asks to stop. */
RLV_API RlvResult rlv_crowd_model_build(RlvContext context, const char *path, const RlvCrowdClipName *clips,
                                        size_t clip_count, const RlvCrowdBuildSettings *settings, RlvProgress progress,
                                        void *user, RlvCrowdModel *out);

/* Makes a model with the clusters of another one, and with the vertices, the skeleton and the clip_count clips of a file that
 * was sculpted or has other clips since; without clips all of the file. Errors and bounds are measured anew, so that cuts hold
 * them, which takes less time than a build. Of the settings pose_distance and pose_rate count. settings, progress and report
 * may be NULL. Fails as rlv_crowd_model_build does, and if the file has other triangles than model was built from, or
 * vertices that were at one place with the same bones and no longer are. */
RLV_API RlvResult rlv_crowd_model_refit(RlvCrowdModel model, const char *path, const RlvCrowdClipName *clips,
                                        size_t clip_count, const RlvCrowdBuildSettings *settings, RlvProgress progress,
                                        void *user, RlvCrowdRefitReport *report, RlvCrowdModel *out);

/* Makes a model with the same clusters whose bones are blended as blend says, an RlvCrowdBlend. Dual quaternions have vertices
 * elsewhere: errors and boxes are measured anew and hold for both, which takes about as long as a refit. Files do not say how
 * bones are blended: a model that is built, refitted or read has RLV_CROWD_BLEND_LINEAR. No failure of its own. */
RLV_API RlvResult rlv_crowd_model_with_blend(RlvCrowdModel model, uint32_t blend, RlvCrowdModel *out);

/* Reads a model (.rcrowd). Fails if the file is damaged or of a later version, or exceeds the memory limit. */
RLV_API RlvResult rlv_crowd_model_read(RlvContext context, const char *path, RlvCrowdModel *out);

/* Writes a model (.rcrowd), which is there when it is complete. Fails if the file cannot be written. */
RLV_API RlvResult rlv_crowd_model_write(RlvCrowdModel model, const char *path);

/* As rlv_crowd_model_read, from the size bytes of a file. Fails as that does. */
RLV_API RlvResult rlv_crowd_model_read_bytes(RlvContext context, const uint8_t *bytes, size_t size, RlvCrowdModel *out);

/* Makes the bytes of the file that rlv_crowd_model_write writes. No failure of its own. */
RLV_API RlvResult rlv_crowd_model_write_bytes(RlvCrowdModel model, RlvBytes *out);

RLV_API RlvResult rlv_crowd_model_retain(RlvCrowdModel model);
RLV_API RlvResult rlv_crowd_model_release(RlvCrowdModel model);

/* Counts and bounds. No failure of its own. */
RLV_API RlvResult rlv_crowd_model_info(RlvCrowdModel model, RlvCrowdModelInfo *out);

/* Name, rate and poses of a clip. Fails if there is no such clip. */
RLV_API RlvResult rlv_crowd_model_clip(RlvCrowdModel model, uint32_t clip, RlvCrowdClip *out);

/* The name of a material, which the triangles give by its number. Fails if there is no such material. */
RLV_API RlvResult rlv_crowd_model_material(RlvCrowdModel model, uint32_t material, RlvCrowdMaterial *out);

/* Writes the vertices, which all clusters share. Fails, and writes nothing, if the capacity is too small; fails where normals
 * or texture coordinates are wanted that the model lacks. */
RLV_API RlvResult rlv_crowd_model_get_vertices(RlvCrowdModel model, const RlvCrowdVertices *vertices);

/* Writes where each vertex goes. Fails if the capacity is too small, or the model was read from a file that does not say it:
 * build it again. */
RLV_API RlvResult rlv_crowd_model_get_collapses(RlvCrowdModel model, RlvCrowdCollapse *collapses, size_t capacity,
                                                size_t stride);

/* Writes the offsets of all morph targets that clips move, one vertex after the other. Fails if the capacity is too small. */
RLV_API RlvResult rlv_crowd_model_get_offsets(RlvCrowdModel model, RlvCrowdOffset *offsets, size_t capacity,
                                              size_t stride);

/* Writes the three vertices and the material of every triangle of all clusters, one cluster after the other; either array
 * may be NULL. Fails if the capacity, in triangles, is too small. */
RLV_API RlvResult rlv_crowd_model_get_triangles(RlvCrowdModel model, uint32_t *triangles, uint32_t *materials,
                                                size_t capacity);

/* Writes all clusters. Fails if the capacity is too small. */
RLV_API RlvResult rlv_crowd_model_get_clusters(RlvCrowdModel model, RlvCrowdCluster *clusters, size_t capacity,
                                               size_t stride);

/* Makes a mesh of the coarsest clusters whose error is at most error, units of the model, in one pose of a clip, with the
 * attributes of the model and `material` on faces; 0 gives the triangles of the input. Fails if the error is below 0, or
 * there is no such clip or pose. */
RLV_API RlvResult rlv_crowd_model_mesh(RlvCrowdModel model, float error, uint32_t clip, uint32_t pose, RlvMesh *out);

/* Makes a crowd of models, without agents. It shares the models. Fails if there is no model. */
RLV_API RlvResult rlv_crowd_create(RlvContext context, const RlvCrowdModel *models, size_t count, RlvCrowd *out);

RLV_API RlvResult rlv_crowd_retain(RlvCrowd crowd);
RLV_API RlvResult rlv_crowd_release(RlvCrowd crowd);

/* Mutates the crowd: adds agents, and writes the number of the first to first, which may be NULL. Fails, and adds none, if
 * a model or clip does not exist, a transform has no inverse, or there are more than 2^24 agents. */
RLV_API RlvResult rlv_crowd_add(RlvCrowd crowd, const RlvCrowdAgent *agents, size_t count, size_t stride,
                                uint32_t *first);

/* Mutates the crowd: moves agents, from number first on, or gives them other clips. Weights that rlv_crowd_set_weights gave
 * stay, unless an agent gets another model. Fails, and changes nothing, as rlv_crowd_add, or if there are not as many. */
RLV_API RlvResult rlv_crowd_set(RlvCrowd crowd, uint32_t first, const RlvCrowdAgent *agents, size_t count,
                                size_t stride);

/* Mutates the crowd: gives an agent count weights of its own, one for each morph target of its model, in place of those of
 * its clip; NULL and 0 give it those of the clip again. What the difference may move its vertices by is added to its errors
 * and boxes, so that cuts hold the error of a view; it is cut group by group at any distance, which needs more time and more
 * triangles. Fails if there is no such agent, count is another than that of the morph targets, or a weight is not finite or
 * too large. */
RLV_API RlvResult rlv_crowd_set_weights(RlvCrowd crowd, uint32_t agent, const float *weights, size_t count);

/* Mutates the crowd: finds what a view draws of it; out may be NULL. With occlusion the nearest agents that were drawn in
 * the last cut are rasterised on the processor, and the boxes of all agents, and of clusters of near ones, tested against their
 * depths. That changes no pixel of a picture with one sample in the middle of each pixel, and rests for 32 cuts where it hides
 * fewer triangles than it costs. With impostors agents of a few pixels that have no weights of their own have no draws, but a quad each: see
 * rlv_crowd_get_impostors. With geomorph vertices move between cuts, which is of use where errors above one pixel may be seen; all
 * agents in view are then cut group by group, and each has draws of its own. With suns or around, agents out of sight count as
 * agents in view. Fails if the view is not finite or has no pixels or direction, occlusion, geomorph or impostors is neither 0 nor
 * 1, the indices of all models do not fit 32 bits, a sun has no direction, an angular radius or around is below 0, with occlusion
 * there are more than 2^26 pixels, suns, or an around above 0, because hidden agents throw shadows too, or with geomorph a model
 * does not say where its vertices go. A cut that fails leaves nothing for rlv_crowd_get, unless it fails with RLV_ERROR_BUSY. */
RLV_API RlvResult rlv_crowd_cut(RlvCrowd crowd, const RlvCrowdView *view, RlvCrowdFrame *out);

/* Writes what rlv_crowd_cut found. Fails, and writes nothing, if a capacity is too small, the last cut failed, or the agents
 * changed since. */
RLV_API RlvResult rlv_crowd_get(RlvCrowd crowd, const RlvCrowdBuffers *buffers);

/* Writes the impostors that rlv_crowd_cut found. Fails as rlv_crowd_get. */
RLV_API RlvResult rlv_crowd_get_impostors(RlvCrowd crowd, const RlvCrowdImpostors *impostors);

#endif
