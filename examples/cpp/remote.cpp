// Has a server simulate a fluid, and writes the particles of each frame while later ones are computed:
//   relievo server run
//   remote dam.toml dam. [ADDRESS]
#include <cstdio>
#include <fstream>
#include <iostream>
#include <sstream>

#include <relievo/relievo.hpp>

int main(int count, char **arguments) {
    if (count < 3) {
        std::cerr << "usage: remote DESCRIPTION PREFIX [ADDRESS]\n";
        return 2;
    }
    try {
        const auto context = relievo::Context::create();
        RlvClientOptions options = RLV_CLIENT_OPTIONS_INIT;
        options.address = count > 3 ? arguments[3] : nullptr;
        const auto client = relievo::Client::connect(context, options);
        std::ostringstream text;
        text << std::ifstream(arguments[1]).rdbuf();
        relievo::ClientScene scene;
        scene.name = arguments[1];
        scene.description = text.str();
        const auto frames = client.submit(scene).frames;
        for (std::uint64_t frame = 0; frame < frames; ++frame) {
            // The job waits for the frame; a host would draw meanwhile.
            const auto job = relievo::Job::fetch(client, scene.name, frame);
            while (job.wait(0.5).state == RLV_JOB_RUNNING) {
                std::cerr << "frame " << frame << ": " << 100 * client.poll(scene.name).fraction << " %\r";
            }
            job.result();
            char name[32];
            std::snprintf(name, sizeof name, "%04u.ply", static_cast<unsigned>(frame));
            job.particles().write(arguments[2] + std::string(name));
        }
        std::cout << frames << " frames\n";
    } catch (const relievo::Error &error) {
        std::cerr << error.what() << '\n';
        return 1;
    }
    return 0;
}
