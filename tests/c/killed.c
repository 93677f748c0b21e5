/* Hosts that are killed while they edit a level: what was made is there when its journal is opened again. */
#define _POSIX_C_SOURCE 200809L
#include "ball.h"

#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

static const char *const PATH = "killed_level.journal";

/* A ball and a level of it, which every host makes for itself. */
typedef struct Host {
    RlvContext context;
    RlvProgressive ball;
    RlvLevel level;
} Host;

static void count_note(void *user, uint32_t level, const char *text) {
    CHECK(level == RLV_LOG_WARNING && strstr(text, "under way") != NULL);
    ++*(size_t *)user;
}

static Host begin(size_t *notes) {
    Host host = {RLV_NULL, RLV_NULL, RLV_NULL};
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.threads = 2;
    CHECK_OK(rlv_context_create(&options, &host.context));
    CHECK_OK(rlv_context_set_log(host.context, count_note, notes));
    RlvMesh mesh = check_ball(host.context, 1.0);
    CHECK_OK(rlv_progressive_create(mesh, NULL, NULL, NULL, &host.ball));
    CHECK_OK(rlv_mesh_release(mesh));
    CHECK_OK(rlv_level_create(host.ball, &host.level));
    CHECK_OK(rlv_level_set_triangles(host.level, 3000));
    return host;
}

static void end(Host host) {
    CHECK_OK(rlv_level_release(host.level));
    CHECK_OK(rlv_progressive_release(host.ball));
    CHECK_OK(rlv_context_release(host.context));
}

/* The edit of a number: each is another one, of the whole ball. */
static void make_edit(RlvLevel level, size_t number) {
    RlvLevelHandle handle = {{{0, 0, 1}, 3.0f, RLV_FALLOFF_SMOOTH}, {0, 0, 0.01f}, {0, 0, 1}, 0.0f, 0};
    handle.translation[number % 3] += 0.02f;
    RlvLevelEdit edit = RLV_LEVEL_EDIT_INIT;
    edit.handles = &handle;
    edit.handle_count = 1;
    CHECK_OK(rlv_level_edit(level, &edit, NULL));
}

static size_t count_edits(RlvLevel level) {
    RlvLevelInfo info = RLV_LEVEL_INFO_INIT;
    CHECK_OK(rlv_level_info(level, &info));
    CHECK(info.redo_count == 0);
    return info.undo_count;
}

/* Goes on where the last host was killed, and tells the number of every edit that is made, until it is killed too. */
static void edit_until_killed(int told) {
    size_t notes = 0;
    Host host = begin(&notes);
    CHECK_OK(rlv_level_open_journal(host.level, PATH));
    for (size_t number = count_edits(host.level);; ++number) {
        CHECK(write(told, &number, sizeof number) == sizeof number);
        make_edit(host.level, number);
    }
}

/* Runs a host and kills it in the edit after so many more. Returns how many edits it had made then. */
static size_t kill_after(size_t before, size_t more) {
    int ends[2];
    size_t number = 0;
    CHECK(pipe(ends) == 0);
    const pid_t child = fork();
    CHECK(child >= 0);
    if (child == 0) {
        close(ends[0]);
        edit_until_killed(ends[1]);
    }
    close(ends[1]);
    CHECK(read(ends[0], &number, sizeof number) == sizeof number);
    /* One that was under way is not there, or it was made before its host could say so. */
    CHECK(number == before || number == before + 1);
    while (number < before + more) {
        CHECK(read(ends[0], &number, sizeof number) == sizeof number);
    }
    CHECK(kill(child, SIGKILL) == 0);
    int status = 0;
    CHECK(waitpid(child, &status, 0) == child && WIFSIGNALED(status) && WTERMSIG(status) == SIGKILL);
    while (read(ends[0], &number, sizeof number) == sizeof number) {
    }
    close(ends[0]);
    return number;
}

static void read_points(RlvLevel level, float *points, size_t count) {
    RlvMesh mesh = RLV_NULL;
    CHECK_OK(rlv_level_mesh(level, &mesh));
    CHECK_OK(rlv_mesh_get_points(mesh, points, count, 0));
    CHECK_OK(rlv_mesh_release(mesh));
}

int main(void) {
    remove(PATH);
    size_t made = 0, notes = 0;
    for (size_t round = 0; round < 8; ++round) {
        made = kill_after(made, 2 + round % 3);
    }

    /* What is there is what a host that was never killed has made. */
    Host host = begin(&notes), other = begin(&notes);
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_level_sync_journal(host.level), "no journal");
    CHECK_OK(rlv_level_open_journal(host.level, PATH));
    const size_t edits = count_edits(host.level);
    CHECK((edits == made || edits == made + 1) && edits >= 16 && notes <= 1);
    for (size_t number = 0; number < edits; ++number) {
        make_edit(other.level, number);
    }
    RlvLevelInfo info = RLV_LEVEL_INFO_INIT;
    CHECK_OK(rlv_level_info(host.level, &info));
    const size_t count = info.vertex_count;
    float *points = malloc(2 * count * 12);
    CHECK(points != NULL);
    read_points(host.level, points, count);
    read_points(other.level, points + 3 * count, count);
    for (size_t k = 0; k < 3 * count; ++k) {
        CHECK_NEAR(points[k], points[3 * count + k], 1e-5);
    }
    free(points);

    /* One level has it, of the same mesh, before its first edit. */
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_open_journal(host.level, PATH), "has a journal already");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_level_open_journal(other.level, PATH), "has edits already");
    RlvLevel third = RLV_NULL;
    CHECK_OK(rlv_level_create(host.ball, &third));
    CHECK_FAILS(RLV_ERROR_BUSY, rlv_level_open_journal(third, PATH), "another program");

    /* What is taken back stays so, and what follows without the journal is not in it. */
    CHECK_OK(rlv_level_undo(host.level));
    CHECK_OK(rlv_level_undo(host.level));
    CHECK_OK(rlv_level_redo(host.level));
    CHECK_OK(rlv_level_sync_journal(host.level));
    CHECK_OK(rlv_level_close_journal(host.level));
    make_edit(host.level, 0);
    CHECK_OK(rlv_level_undo(host.level));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_level_close_journal(host.level), "no journal");
    CHECK_OK(rlv_level_open_journal(third, PATH));
    CHECK_OK(rlv_level_info(third, &info));
    CHECK(info.undo_count == edits - 1 && info.redo_count == 1 && notes <= 1);
    CHECK_OK(rlv_level_redo(third));
    CHECK(count_edits(third) == edits);
    CHECK_OK(rlv_level_release(third));
    CHECK(remove(PATH) == 0);
    CHECK_OK(rlv_level_create(host.ball, &third));
    CHECK(rlv_level_open_journal(third, "nowhere/level.journal") == RLV_ERROR_NOT_FOUND);
    CHECK_OK(rlv_level_release(third));
    end(other);
    end(host);
    return 0;
}
