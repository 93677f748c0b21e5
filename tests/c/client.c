/* Clients of `relievo server run`, the first argument: scenes, jobs, steering, forces, foam, a server that is killed, and what is
 * refused. */
#define _POSIX_C_SOURCE 200809L
#include "sheet.h"

#include <fcntl.h>
#include <signal.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

static const char *const DAM =
    "frames = 4\n[fluid]\nspacing = 0.05\n[basin]\nlow = [0, 0, 0]\nhigh = [0.8, 0.4, 0.4]\n[[fill]]\nmesh = \"block.obj\"\n";
static const char *const LONG =
    "frames = 4000\n[fluid]\nspacing = 0.05\n[[block]]\nlow = [0, 0, 0]\nhigh = [0.4, 0.2, 0.4]\n";
static const char *const FOAM =
    "frames = 8\n[fluid]\nspacing = 0.05\n[basin]\nlow = [0, 0, 0]\nhigh = [0.8, 0.4, 0.4]\n"
    "[[block]]\nlow = [0, 0, 0]\nhigh = [0.4, 0.2, 0.4]\n"
    "[foam]\ntrapped_air = [0.1, 1]\ncrests = [0.1, 1]\nenergy = [0.01, 0.5]\nair_rate = 400\n";
static const char *const BLOCK =
    "v 0 0 0\nv .4 0 0\nv .4 .2 0\nv 0 .2 0\nv 0 0 .4\nv .4 0 .4\nv .4 .2 .4\nv 0 .2 .4\n"
    "f 4 3 2 1\nf 5 6 7 8\nf 1 2 6 5\nf 2 3 7 6\nf 3 4 8 7\nf 4 1 5 8\n";

static const char *command;
static char folder[64], address[96], cache[96], block[96], file[96];

/* Starts the server, which prints nothing here. */
static pid_t serve(void) {
    const pid_t child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        const int nowhere = open("/dev/null", O_WRONLY);
        dup2(nowhere, 1);
        dup2(nowhere, 2);
        execl(command, command, "server", "run", "--listen", address, "--cache", cache, "--threads", "1", (char *)NULL);
        _exit(127);
    }
    return child;
}

static void kill_server(pid_t server) {
    int status = 0;
    CHECK(kill(server, SIGKILL) == 0);
    CHECK(waitpid(server, &status, 0) == server);
}

static RlvClientScene scene_of(const char *name, const char *description) {
    RlvClientScene scene = RLV_CLIENT_SCENE_INIT;
    scene.name = name;
    scene.description = description;
    return scene;
}

static RlvClientStatus poll_scene(RlvClient client, const char *name) {
    RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
    CHECK_OK(rlv_client_poll(client, name, &status));
    return status;
}

/* Positions by the numbers of particles. */
static void positions_of(RlvParticles particles, float (*places)[3], size_t capacity) {
    RlvParticlesInfo info = RLV_PARTICLES_INFO_INIT;
    static float points[1000][3];
    static uint32_t numbers[1000];
    CHECK_OK(rlv_particles_info(particles, &info));
    CHECK(info.count == capacity && capacity <= 1000 && info.has_numbers == 1);
    CHECK_OK(rlv_particles_get_points(particles, points[0], 1000, 0));
    CHECK_OK(rlv_particles_get_numbers(particles, numbers, 1000, 0));
    for (size_t at = 0; at < capacity; ++at) {
        CHECK(numbers[at] < capacity);
        memcpy(places[numbers[at]], points[at], sizeof points[at]);
    }
}

/* A scene with a mesh, its frames as particles, files, meshes and level sets. */
static void check_frames(RlvContext context, RlvClient client) {
    const RlvClientFile files[1] = {{"block.obj", block}};
    static float sent[1000][3], stored[1000][3], halves[1000][3];
    RlvClientScene scene = scene_of("dam", DAM);
    RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
    RlvClientFetch fetch = RLV_CLIENT_FETCH_INIT;
    RlvParticlesInfo info = RLV_PARTICLES_INFO_INIT;
    RlvMeshInfo mesh_info = RLV_MESH_INFO_INIT;
    RlvParticles particles = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    size_t count = 0;
    uint32_t velocity = 0;
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_client_submit(client, &scene, NULL, NULL, NULL), "block.obj");
    scene.files = files;
    scene.file_count = 1;
    CHECK_OK(rlv_client_submit(client, &scene, NULL, NULL, &status));
    CHECK(status.frames == 5 && status.text[0] == 0);
    CHECK_OK(rlv_client_submit(client, &scene, NULL, NULL, NULL));
    CHECK_OK(rlv_client_wait(client, "dam", 4, NULL, NULL, &status));
    CHECK(status.state == RLV_CLIENT_DONE && status.ready == 5 && status.seconds_left == 0.0);
    count = (size_t)status.particles;
    CHECK(count > 50 && count <= 1000);

    CHECK_OK(rlv_client_fetch(client, "dam", 4, NULL, NULL, NULL, &particles));
    CHECK_OK(rlv_particles_info(particles, &info));
    CHECK(info.has_time == 1 && info.channel_count >= 1);
    CHECK_NEAR(info.time, 4.0 / 24.0, 1e-5);
    CHECK_NEAR(info.spacing, 0.05, 1e-9);
    CHECK_OK(rlv_particles_find_channel(particles, "velocity", &velocity));
    positions_of(particles, sent, count);
    CHECK_OK(rlv_particles_release(particles));
    CHECK_OK(rlv_client_save(client, "dam", 4, RLV_CLIENT_FRAME, NULL, file, NULL, NULL));
    CHECK_OK(rlv_particles_read(context, file, &particles));
    positions_of(particles, stored, count);
    CHECK_OK(rlv_particles_release(particles));
    CHECK(memcmp(sent, stored, count * sizeof sent[0]) == 0);

    fetch.is_half = 1;
    fetch.channels = "number";
    CHECK_OK(rlv_client_fetch(client, "dam", 4, &fetch, NULL, NULL, &particles));
    CHECK_OK(rlv_particles_info(particles, &info));
    CHECK(info.channel_count == 0);
    positions_of(particles, halves, count);
    CHECK_OK(rlv_particles_release(particles));
    for (size_t at = 0; at < count; ++at) {
        for (int axis = 0; axis < 3; ++axis) {
            CHECK_NEAR(halves[at][axis], sent[at][axis], 1.0 / 65535);
        }
    }
    fetch = (RlvClientFetch)RLV_CLIENT_FETCH_INIT;
    fetch.particles = RLV_CLIENT_SURFACE;
    fetch.is_plain = 1;
    CHECK_OK(rlv_client_fetch(client, "dam", 4, &fetch, NULL, NULL, &particles));
    CHECK_OK(rlv_particles_info(particles, &info));
    CHECK(info.count > 0 && info.count <= count);
    CHECK_OK(rlv_particles_release(particles));

    CHECK_OK(rlv_client_fetch_mesh(client, "dam", 4, "cell = 1.0", NULL, NULL, &mesh));
    CHECK_OK(rlv_mesh_info(mesh, &mesh_info));
    CHECK(mesh_info.triangle_count > 50 && mesh_info.low[1] > -0.1f && mesh_info.high[0] < 0.9f);
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_client_save(client, "dam", 4, RLV_CLIENT_LEVEL_SET, NULL, file, NULL, NULL));
    FILE *const written = fopen(file, "rb");
    char magic[4] = {0};
    CHECK(written != NULL && fread(magic, 1, 4, written) == 4 && memcmp(magic, " BDV", 4) == 0);
    fclose(written);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_fetch_mesh(client, "dam", 4, "cells = 1", NULL, NULL, &mesh), "cells");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_client_fetch(client, "dam", 5, NULL, NULL, NULL, &particles), "frame");

    /* Without gravity after frame 2 the water is elsewhere. */
    CHECK_OK(rlv_client_steer(client, "dam", 2, "[fluid]\ngravity = [0, 0, 0]\n", &status));
    CHECK(status.ready == 3);
    CHECK_OK(rlv_client_wait(client, "dam", 4, NULL, NULL, NULL));
    CHECK_OK(rlv_client_fetch(client, "dam", 4, NULL, NULL, NULL, &particles));
    positions_of(particles, stored, count);
    CHECK_OK(rlv_particles_release(particles));
    CHECK(memcmp(sent, stored, count * sizeof sent[0]) != 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_steer(client, "dam", 2, "[fluid]\nweight = 1\n", NULL), "weight");
}

/* Jobs beside calls, cancels, and a server that is killed and comes back. Returns the new server. */
static pid_t check_jobs(RlvClient client, pid_t server) {
    const RlvClientScene scene = scene_of("long", LONG);
    RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
    RlvJobInfo info = RLV_JOB_INFO_INIT;
    RlvJob job = RLV_NULL;
    RlvParticles particles = RLV_NULL, again = RLV_NULL;
    RlvMesh mesh = RLV_NULL;
    int left = 3;
    CHECK_OK(rlv_job_client_submit(client, &scene, &job));
    CHECK_OK(rlv_job_wait(job, -1, &info));
    CHECK(info.state == RLV_JOB_DONE);
    CHECK_OK(rlv_job_client_status(job, &status));
    CHECK(status.frames == 4001 && status.state == RLV_CLIENT_RUNNING);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_particles(job, &particles), "particles");
    CHECK_OK(rlv_job_release(job));

    CHECK_OK(rlv_job_client_fetch(client, "long", 3, NULL, &job));
    CHECK(poll_scene(client, "long").frames == 4001);
    CHECK_OK(rlv_job_wait(job, -1, &info));
    CHECK_OK(rlv_job_particles(job, &particles));
    CHECK_OK(rlv_job_particles(job, &again));
    CHECK(particles.id == again.id);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_client_status(job, &status), "scene");
    CHECK_OK(rlv_particles_release(particles));
    CHECK_OK(rlv_particles_release(again));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_job_client_fetch_mesh(client, "long", 3, "cell = 2.0", &job));
    CHECK_OK(rlv_job_wait(job, -1, &info));
    CHECK_OK(rlv_job_mesh(job, &mesh));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_job_release(job));

    CHECK_OK(rlv_job_client_fetch(client, "long", 4000, NULL, &job));
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_job_particles(job, &particles), "rlv_job_wait");
    CHECK_OK(rlv_job_cancel(job));
    CHECK_OK(rlv_job_wait(job, -1, &info));
    CHECK(info.state == RLV_JOB_CANCELLED);
    CHECK_OK(rlv_job_release(job));
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_client_wait(client, "long", 4000, check_patience, &left, NULL), "");

    const uint64_t confirmed = poll_scene(client, "long").ready;
    kill_server(server);
    left = 5;
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_client_wait(client, "long", 4000, check_patience, &left, NULL), "connect");
    server = serve();
    CHECK(poll_scene(client, "long").ready >= confirmed);
    CHECK_OK(rlv_client_wait(client, "long", confirmed + 1, NULL, NULL, &status));

    CHECK_OK(rlv_client_control(client, "long", RLV_CLIENT_PAUSE));
    CHECK(poll_scene(client, "long").state == RLV_CLIENT_PAUSED);
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_client_wait(client, "long", 4000, NULL, NULL, NULL), "paused");
    CHECK_OK(rlv_client_control(client, "long", RLV_CLIENT_RESUME));
    CHECK_OK(rlv_client_control(client, "long", RLV_CLIENT_CANCEL));
    CHECK(poll_scene(client, "long").state == RLV_CLIENT_CANCELLED);
    CHECK_OK(rlv_client_control(client, "long", RLV_CLIENT_REMOVE));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_client_poll(client, "long", &status), "long");
    return server;
}

/* Accelerations by the host lift what would fall. */
static void check_forces(RlvClient client) {
    RlvClientScene scene = scene_of("forced", LONG);
    RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
    static float lift[1000][3], before[1000][3], after[1000][3];
    RlvParticles particles = RLV_NULL;
    scene.is_forced = 1;
    CHECK_OK(rlv_client_submit(client, &scene, NULL, NULL, NULL));
    CHECK_OK(rlv_client_wait(client, "forced", 0, NULL, NULL, &status));
    CHECK(status.state == RLV_CLIENT_FORCES && status.ready == 1);
    const size_t count = (size_t)status.particles;
    CHECK(count > 50 && count <= 1000);
    CHECK_OK(rlv_client_fetch(client, "forced", 0, NULL, NULL, NULL, &particles));
    positions_of(particles, before, count);
    CHECK_OK(rlv_particles_release(particles));
    for (size_t at = 0; at < count; ++at) {
        lift[at][1] = 30.0f;
        lift[at][2] = 30.0f;
    }
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_client_force(client, "forced", 1, lift[0], count, 0, NULL), "frame 1");
    CHECK_OK(rlv_client_force(client, "forced", 0, lift[0], count, 0, &status));
    CHECK_OK(rlv_client_wait(client, "forced", 1, NULL, NULL, NULL));
    CHECK_OK(rlv_client_fetch(client, "forced", 1, NULL, NULL, NULL, &particles));
    positions_of(particles, after, count);
    CHECK_OK(rlv_particles_release(particles));
    double risen = 0;
    for (size_t at = 0; at < count; ++at) {
        risen += (after[at][1] - before[at][1]) / (double)count;
    }
    CHECK_NEAR(risen, 0.5 * 30.0 / 24 / 24, 0.01);
    lift[7][0] = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_force(client, "forced", 1, lift[0], count, 0, NULL), "acceleration 7");
    CHECK_OK(rlv_client_control(client, "forced", RLV_CLIENT_REMOVE));
}

static void check_foam(RlvClient client) {
    RlvClientScene scene = scene_of("foam", FOAM);
    RlvParticlesInfo info = RLV_PARTICLES_INFO_INIT;
    RlvParticles particles = RLV_NULL;
    uint32_t kind = 0;
    scene.kind = "foam";
    CHECK_OK(rlv_client_submit(client, &scene, NULL, NULL, NULL));
    CHECK_OK(rlv_client_wait(client, "foam", 8, NULL, NULL, NULL));
    CHECK_OK(rlv_client_fetch(client, "foam", 8, NULL, NULL, NULL, &particles));
    CHECK_OK(rlv_particles_info(particles, &info));
    CHECK(info.count > 0);
    CHECK_OK(rlv_particles_find_channel(particles, "type", &kind));
    CHECK_OK(rlv_particles_release(particles));
}

static void check_refusals(RlvContext context, RlvClient client) {
    RlvClientOptions options = RLV_CLIENT_OPTIONS_INIT;
    RlvClientScene scene = scene_of("wrong", "frames = -1");
    RlvClientFetch fetch = RLV_CLIENT_FETCH_INIT;
    RlvClientStatus status = RLV_CLIENT_STATUS_INIT;
    RlvClient other = RLV_NULL;
    RlvParticles particles = RLV_NULL;
    RlvJob job = RLV_NULL;
    options.address = "unix:";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_connect(context, &options, &other), "path");
    options.address = "unix:client_that_is_not_there";
    options.patience = 0;
    CHECK_FAILS(RLV_ERROR_IO, rlv_client_connect(context, &options, &other), "server");
    options.patience = NAN;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_connect(context, &options, &other), "patience");
    options.patience = 1;
    options.timeout = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_connect(context, &options, &other), "timeout");
    options.timeout = 1;
    options.address = "tls://127.0.0.1:1";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_connect(context, &options, &other), "certificates");
    options.struct_size = 4;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_connect(context, &options, &other), "struct_size");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_connect(context, NULL, NULL), "NULL");
    CHECK(other.id == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_submit(client, &scene, NULL, NULL, NULL), "frames");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_submit(client, NULL, NULL, NULL, NULL), "NULL");
    scene.file_count = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_submit(client, &scene, NULL, NULL, NULL), "files");
    scene = scene_of(NULL, LONG);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_submit(client, &scene, NULL, NULL, NULL), "name");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_client_submit(client, &scene, &job), "name");
    scene = scene_of("a\nb", LONG);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_submit(client, &scene, NULL, NULL, NULL), "control");
    scene = scene_of("wrong", LONG);
    scene.kind = "smoke";
    CHECK_FAILS(RLV_ERROR_UNSUPPORTED, rlv_client_submit(client, &scene, NULL, NULL, NULL), "foam");
    scene.is_forced = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_submit(client, &scene, NULL, NULL, NULL), "is_forced");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_client_poll(client, "nobody", &status), "nobody");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_poll(client, NULL, &status), "scene");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_poll(client, "dam", NULL), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_control(client, "dam", 4), "action");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_force(client, "dam", 0, NULL, 0, 0, NULL), "accelerations");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_save(client, "dam", 0, 3, NULL, file, NULL, NULL), "form");
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_client_save(client, "dam", 0, 0, NULL, "no/such/folder", NULL, NULL), "folder");
    fetch.particles = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_fetch(client, "dam", 0, &fetch, NULL, NULL, &particles), "particles");
    fetch.particles = RLV_CLIENT_ALL;
    fetch.is_half = 2;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_fetch(client, "dam", 0, &fetch, NULL, NULL, &particles), "is_half");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_fetch(client, "dam", 0, NULL, NULL, NULL, NULL), "NULL");
    CHECK(particles.id == 0 && job.id == 0);
}

int main(int count, char **arguments) {
    RlvContext context = RLV_NULL;
    RlvClient client = RLV_NULL;
    RlvClientOptions options = RLV_CLIENT_OPTIONS_INIT;
    RlvClientInfo info = RLV_CLIENT_INFO_INIT;
    char removal[96];
    CHECK(count == 2);
    command = arguments[1];
    snprintf(folder, sizeof folder, "client_%ld", (long)getpid());
    snprintf(address, sizeof address, "unix:%s/socket", folder);
    snprintf(cache, sizeof cache, "%s/cache", folder);
    snprintf(block, sizeof block, "%s/block.obj", folder);
    snprintf(file, sizeof file, "%s/frame.rlvfluid", folder);
    CHECK(mkdir(folder, 0700) == 0);
    FILE *const mesh = fopen(block, "w");
    CHECK(mesh != NULL && fputs(BLOCK, mesh) >= 0 && fclose(mesh) == 0);

    pid_t server = serve();
    CHECK_OK(rlv_context_create(NULL, &context));
    options.address = address;
    CHECK_OK(rlv_client_connect(context, &options, &client));
    CHECK_OK(rlv_client_info(client, &info));
    CHECK(info.protocol[0] == 1 && strcmp(info.user, "local") == 0 && strcmp(info.kinds, "fluid foam") == 0);
    check_frames(context, client);
    server = check_jobs(client, server);
    check_forces(client);
    check_foam(client);
    check_refusals(context, client);
    check_idle(client.id, "client");
    CHECK_OK(rlv_client_release(client));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_client_info(client, &info), "");
    CHECK_OK(rlv_context_release(context));
    kill_server(server);
    snprintf(removal, sizeof removal, "rm -r %s", folder);
    CHECK(system(removal) == 0);
    return 0;
}
