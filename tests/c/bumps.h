/* A bumpy sheet of triangles in a file and agents, for the tests of crowds. */
#ifndef BUMPS_H
#define BUMPS_H

#include "check.h"

/* Writes side x side points, 0.1 apart, and two triangles for each square between them as OBJ. */
static inline void check_write_bumps(const char *path, int side) {
    FILE *text = fopen(path, "w");
    CHECK(text != NULL);
    for (int point = 0; point < side * side; ++point) {
        const double x = point % side, y = point / side;
        fprintf(text, "v %.9g %.9g %.9g\n", 0.1 * x, 0.1 * y, 0.05 * sin(0.7 * x) * cos(0.5 * y));
    }
    for (int y = 1; y < side; ++y) {
        for (int x = 1; x < side; ++x) {
            const int a = (y - 1) * side + x, b = a + 1, c = b + side, d = a + side;
            fprintf(text, "f %d %d %d\nf %d %d %d\n", a, b, c, a, c, d);
        }
    }
    CHECK(fclose(text) == 0);
}

/* An agent of the first model at (x, 0, z), not turned. */
static inline RlvCrowdAgent check_agent(double x, double z) {
    RlvCrowdAgent agent;
    memset(&agent, 0, sizeof agent);
    agent.transform[0] = agent.transform[4] = agent.transform[8] = 1.0;
    agent.transform[9] = x;
    agent.transform[11] = z;
    return agent;
}

#endif
