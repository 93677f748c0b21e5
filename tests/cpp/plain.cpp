// The wrapper in a program without exceptions and run-time types: calls that succeed work, and a failure prints its message
// and aborts.
#include <csignal>
#include <cstdlib>

#include "relievo/relievo.hpp"

int main() {
    const relievo::Context context = relievo::Context::create();
    const std::vector<relievo::Float3> points = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
    const relievo::Mesh mesh = relievo::Mesh::create(context, points, {3}, {0, 1, 2});
    if (mesh.info().face_count != 1) {
        return EXIT_FAILURE;
    }
    std::signal(SIGABRT, [](int) { std::_Exit(EXIT_SUCCESS); });
    relievo::Mesh::create(context, points, {3}, {0, 1, 7});
    return EXIT_FAILURE;
}
