/* depth FILE: whether an OBJ file is the plane z = 0 with a dent 0.25 deep, exact to a few voxels, as the examples
 * write it. */
#include <stdio.h>
#include <string.h>

int main(int argc, char **argv) {
    FILE *file = argc == 2 ? fopen(argv[1], "r") : NULL;
    char line[256];
    long points = 0, faces = 0, flat = 0;
    double low = 0.0, high = 0.0;
    if (file == NULL) {
        fprintf(stderr, "cannot read the file\n");
        return 1;
    }
    while (fgets(line, sizeof(line), file) != NULL) {
        double x, y, z;
        if (sscanf(line, "v %lf %lf %lf", &x, &y, &z) == 3) {
            ++points;
            low = z < low ? z : low;
            high = z > high ? z : high;
            flat += z == 0.0;
        }
        faces += strncmp(line, "f ", 2) == 0;
    }
    fclose(file);
    printf("%ld points, %ld faces, z from %g to %g\n", points, faces, low, high);
    return points < 10000 || faces < points || flat < points / 4 || high > 1e-6 || low > -0.245 || low < -0.26;
}
