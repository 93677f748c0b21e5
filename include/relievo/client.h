/* Relievo: clients of the simulation server, `relievo server run`. docs/server.md is its manual.
 *
 * A client submits scenes, waits for their frames and fetches them, while the server simulates. Its calls may run at the
 * same time on several threads: each takes a connection of its own. Where a connection breaks, or the server is started
 * anew, a call connects again and goes on, as long as its patience lasts. The scenes are the server's: they go on when the
 * client is gone, and every client of the same user has them. Calls that take a progress callback can be cancelled by it,
 * also while they connect; that does not stop the simulation, which rlv_client_control does. */
#ifndef RELIEVO_CLIENT_H
#define RELIEVO_CLIENT_H

#include "relievo/mesh.h"
#include "relievo/particles.h"

typedef struct RlvClient {
    uint64_t id;
} RlvClient;

typedef struct RlvClientOptions {
    uint32_t struct_size;
    uint32_t reserved;       /* 0 */
    const char *address;     /* host:port, tls://host:port or unix:/path; NULL for 127.0.0.1:7350 */
    const char *token;       /* the user's token; NULL where the server has no users */
    const char *authorities; /* file of the certificates, in PEM, that a server at tls:// is checked against; else NULL */
    double timeout;          /* seconds that a call waits for bytes, above 0 and at most 86400 */
    double patience;         /* seconds that a call tries to connect for, 0 to 86400 */
} RlvClientOptions;

#define RLV_CLIENT_OPTIONS_INIT {sizeof(RlvClientOptions), 0, NULL, NULL, NULL, 60.0, 30.0}

/* The state of a scene. */
typedef enum RlvClientState {
    RLV_CLIENT_RUNNING = 0,   /* frames are computed, or will be when it is the scene's turn */
    RLV_CLIENT_FORCES = 1,    /* the next frame waits for rlv_client_force */
    RLV_CLIENT_PAUSED = 2,
    RLV_CLIENT_DONE = 3,      /* all frames are there */
    RLV_CLIENT_CANCELLED = 4,
    RLV_CLIENT_FAILED = 5     /* the simulation failed; text says why */
} RlvClientState;

typedef struct RlvClientStatus {
    uint32_t struct_size;
    uint32_t state;           /* RlvClientState */
    uint64_t ready;           /* frames that can be fetched: 0 to ready - 1 */
    uint64_t frames;          /* frames that there will be */
    uint64_t particles;       /* particles in the last frame */
    double seconds_left;      /* estimated computation until the last frame; -1 until a frame was computed */
    float fraction;           /* the part of the next frame that is computed, 0 to 1 */
    uint32_t reserved;        /* 0 */
    char text[RLV_TEXT_SIZE]; /* why the simulation failed; empty otherwise */
} RlvClientStatus;

#define RLV_CLIENT_STATUS_INIT {sizeof(RlvClientStatus), RLV_CLIENT_RUNNING, 0, 0, 0, -1.0, 0.0f, 0, {0}}

typedef struct RlvClientInfo {
    uint32_t struct_size;
    uint32_t protocol[2];       /* major and minor version of the server's protocol */
    uint32_t reserved;          /* 0 */
    char server[RLV_NAME_SIZE]; /* name and version of the server */
    char user[RLV_TEXT_SIZE];   /* the user that the token belongs to */
    char kinds[RLV_TEXT_SIZE];  /* kinds of simulations that the server makes, with spaces between them */
} RlvClientInfo;

#define RLV_CLIENT_INFO_INIT {sizeof(RlvClientInfo), {0, 0}, 0, {0}, {0}, {0}}

/* A file of a scene. */
typedef struct RlvClientFile {
    const char *name; /* as the description writes it */
    const char *path; /* where the file is on this machine */
} RlvClientFile;

/* A scene to submit. */
typedef struct RlvClientScene {
    uint32_t struct_size;
    uint32_t is_forced;      /* 1 if each frame waits for rlv_client_force, else 0 */
    const char *name;        /* 1 to 128 bytes, without control characters */
    const char *kind;        /* "fluid" or "foam"; NULL for "fluid" */
    const char *description; /* the text that `relievo server submit` reads from a file; docs/fluids.md lists its keys */
    const RlvClientFile *files;
    size_t file_count;
} RlvClientScene;

#define RLV_CLIENT_SCENE_INIT {sizeof(RlvClientScene), 0, NULL, NULL, NULL, NULL, 0}

/* What becomes of a scene. */
typedef enum RlvClientAction {
    RLV_CLIENT_PAUSE = 0,  /* stops after the frame that is computed */
    RLV_CLIENT_RESUME = 1, /* goes on, also after it was cancelled or failed */
    RLV_CLIENT_CANCEL = 2, /* stops at once; its frames stay */
    RLV_CLIENT_REMOVE = 3  /* forgets the scene and its files */
} RlvClientAction;

/* Which particles are fetched. */
typedef enum RlvClientParticles {
    RLV_CLIENT_ALL = 0,
    RLV_CLIENT_BLIND = 1,  /* those at the surface, and the blind ones beside them; they have the channel `blind` */
    RLV_CLIENT_SURFACE = 2 /* those at the surface */
} RlvClientParticles;

/* How a frame is fetched. */
typedef struct RlvClientFetch {
    uint32_t struct_size;
    uint32_t particles;   /* RlvClientParticles */
    uint32_t is_half;     /* 1 for 16-bit numbers: positions within 1/65535 of their box; 0 for exact ones */
    uint32_t is_plain;    /* 1 to send without compression, for connections that are faster than it */
    const char *channels; /* names of the channels beside the positions, with commas between them; NULL for all */
} RlvClientFetch;

#define RLV_CLIENT_FETCH_INIT {sizeof(RlvClientFetch), RLV_CLIENT_ALL, 0, 0, NULL}

/* What rlv_client_save writes. */
typedef enum RlvClientForm {
    RLV_CLIENT_FRAME = 0,    /* the frame as the simulation stored it, .rlvfluid, to the bit */
    RLV_CLIENT_MESH = 1,     /* a mesh of the surface, made at the server: binary PLY */
    RLV_CLIENT_LEVEL_SET = 2 /* a level set of the surface, made at the server: OpenVDB */
} RlvClientForm;

/* Connects to a server; options may be NULL for the defaults. Fails with RLV_ERROR_IO if there is no server within the
 * patience, and if the token or the certificate is refused or the server speaks another protocol. */
RLV_API RlvResult rlv_client_connect(RlvContext context, const RlvClientOptions *options, RlvClient *out);

RLV_API RlvResult rlv_client_retain(RlvClient client);
RLV_API RlvResult rlv_client_release(RlvClient client);

/* Returns the server and the user of the last connection. Fails if a text is no place for it. */
RLV_API RlvResult rlv_client_info(RlvClient client, RlvClientInfo *out);

/* Sends the files that the server lacks, and has it simulate a scene. The same scene again changes nothing. status may be
 * NULL. Fails if the server refuses the description or a file, another scene has the name, or a limit is exceeded. */
RLV_API RlvResult rlv_client_submit(RlvClient client, const RlvClientScene *scene, RlvProgress progress, void *user,
                                    RlvClientStatus *status);

/* Returns the state of a scene, without waiting. That its simulation failed is no failure of this call. Fails with
 * RLV_ERROR_NOT_FOUND if there is no such scene. */
RLV_API RlvResult rlv_client_poll(RlvClient client, const char *scene, RlvClientStatus *out);

/* Waits until a frame can be fetched. status may be NULL. Fails with RLV_ERROR_CANCELLED if the scene is paused or cancelled,
 * or has no such frame; with the failure of the simulation if that failed. */
RLV_API RlvResult rlv_client_wait(RlvClient client, const char *scene, uint64_t frame, RlvProgress progress, void *user,
                                  RlvClientStatus *status);

/* Changes keys of a description after a frame: changes is a text of the description's format. Later frames are computed
 * anew. status may be NULL. Fails, and changes nothing, if the changes do not fit the description. */
RLV_API RlvResult rlv_client_steer(RlvClient client, const char *scene, uint64_t frame, const char *changes,
                                   RlvClientStatus *status);

/* Sends the accelerations, three floats each in m/s², of all particles of a frame on the way to the next one; the order is
 * that of rlv_client_fetch. stride is in bytes, 0 for packed. status may be NULL. Fails if the scene is at another frame, takes
 * no accelerations or has another number of particles. */
RLV_API RlvResult rlv_client_force(RlvClient client, const char *scene, uint64_t frame, const float *accelerations,
                                   size_t count, size_t stride, RlvClientStatus *status);

/* Pauses, resumes, cancels or removes a scene; action is an RlvClientAction. Fails with RLV_ERROR_NOT_FOUND if there is no
 * such scene. */
RLV_API RlvResult rlv_client_control(RlvClient client, const char *scene, uint32_t action);

/* Makes particles of a frame; fetch may be NULL for the defaults. Fails with RLV_ERROR_BUSY if the frame is not computed yet, and
 * if it does not fit the memory limit of the context. */
RLV_API RlvResult rlv_client_fetch(RlvClient client, const char *scene, uint64_t frame, const RlvClientFetch *fetch,
                                   RlvProgress progress, void *user, RlvParticles *out);

/* Makes a mesh of the surface of a frame, which the server makes. settings is a text in TOML or NULL for the defaults: `cell`
 * in spacings (0.5), `function` ("zhu-bridson", "blobs", "density" or "anisotropic"), `smooth` steps (0). Fails as
 * rlv_client_fetch does, and if a setting is refused. */
RLV_API RlvResult rlv_client_fetch_mesh(RlvClient client, const char *scene, uint64_t frame, const char *settings,
                                        RlvProgress progress, void *user, RlvMesh *out);

/* Writes a frame or its surface to a file, which has its name when it is whole; form is an RlvClientForm, settings as for
 * rlv_client_fetch_mesh. Fails as rlv_client_fetch_mesh does, and if the file cannot be written. */
RLV_API RlvResult rlv_client_save(RlvClient client, const char *scene, uint64_t frame, uint32_t form,
                                  const char *settings, const char *path, RlvProgress progress, void *user);

#endif
