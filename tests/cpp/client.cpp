// The C++ wrapper of clients: a scene of a `relievo server run`, the first argument, its frames, jobs, and exceptions.
#include <relievo/relievo.hpp>

#include <cstdio>
#include <cstdlib>
#include <fcntl.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#define CHECK(condition)                                                              \
    do {                                                                              \
        if (!(condition)) {                                                           \
            std::fprintf(stderr, "%s:%d: failed: %s\n", __FILE__, __LINE__, #condition); \
            std::exit(1);                                                             \
        }                                                                             \
    } while (0)

namespace {

/// A server in a folder of its own, which is killed and removed at the end.
class Server {
public:
    explicit Server(const char *command) : folder_("client_cpp_" + std::to_string(getpid())) {
        const std::string cache = folder_ + "/cache", listen = address();
        CHECK(std::system(("mkdir " + folder_).c_str()) == 0);
        child_ = fork();
        CHECK(child_ >= 0);
        if (child_ == 0) {
            const int nowhere = open("/dev/null", O_WRONLY);
            dup2(nowhere, 1);
            dup2(nowhere, 2);
            execl(command, command, "server", "run", "--listen", listen.c_str(), "--cache", cache.c_str(), "--threads", "1",
                  static_cast<char *>(nullptr));
            _exit(127);
        }
    }
    Server(const Server &) = delete;
    Server &operator=(const Server &) = delete;
    ~Server() {
        kill(child_, SIGKILL);
        waitpid(child_, nullptr, 0);
        CHECK(std::system(("rm -r " + folder_).c_str()) == 0);
    }

    std::string address() const { return "unix:" + folder_ + "/socket"; }
    std::string path(const std::string &name) const { return folder_ + "/" + name; }

private:
    std::string folder_;
    pid_t child_ = -1;
};

} // namespace

int main(int count, char **arguments) {
    CHECK(count == 2);
    const Server server(arguments[1]);
    const auto context = relievo::Context::create();
    RlvClientOptions options = RLV_CLIENT_OPTIONS_INIT;
    const std::string address = server.address();
    options.address = address.c_str();
    const auto client = relievo::Client::connect(context, options);
    CHECK(std::string(client.info().user) == "local");

    relievo::ClientScene scene;
    scene.name = "dam";
    scene.description = "frames = 6\n[fluid]\nspacing = 0.05\n[[block]]\nlow = [0, 0, 0]\nhigh = [0.4, 0.2, 0.4]\n";
    float last = 0;
    const relievo::Progress rising = [&](float fraction, const char *) {
        CHECK(fraction >= last && fraction <= 1);
        last = fraction;
        return true;
    };
    CHECK(client.submit(scene).frames == 7);
    CHECK(client.wait("dam", 6, rising).state == RLV_CLIENT_DONE && last > 0);
    const auto particles = client.fetch("dam", 6);
    CHECK(particles.points().size() == client.poll("dam").particles && particles.channel("velocity").width == 3);
    CHECK(client.fetch_mesh("dam", 6, "cell = 1.0").triangles().size() > 50);
    client.save("dam", 6, RLV_CLIENT_FRAME, server.path("6.rlvfluid"));
    CHECK(relievo::Particles::read(context, server.path("6.rlvfluid")).points().size() == particles.points().size());

    const auto job = relievo::Job::fetch(client, "dam", 3);
    CHECK(job.wait().state == RLV_JOB_DONE && job.particles().points().size() == particles.points().size());
    const auto meshing = relievo::Job::fetch_mesh(client, "dam", 3, "cell = 1.0");
    CHECK(meshing.wait().state == RLV_JOB_DONE && meshing.mesh().triangles().size() > 50);

    CHECK(client.steer("dam", 4, "[fluid]\nviscosity = 0.1\n").ready == 5);
    scene.name = "pushed";
    scene.is_forced = true;
    const auto submission = relievo::Job::submit(client, scene);
    CHECK(submission.wait().state == RLV_JOB_DONE && submission.client_status().frames == 7);
    const auto pushed = client.wait("pushed", 0).particles;
    client.force("pushed", 0, std::vector<relievo::Float3>(pushed, {0, 0, 5}));
    CHECK(client.wait("pushed", 1).ready == 2);
    client.control("pushed", RLV_CLIENT_REMOVE);
    try {
        client.poll("pushed");
        CHECK(false);
    } catch (const relievo::Error &error) {
        CHECK(error.result() == RLV_ERROR_NOT_FOUND);
    }
    return 0;
}
