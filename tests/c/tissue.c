/* Soft tissue: models built, of grids and of files; simulations stepped, pressed, driven, activated, kept and as jobs. */
#include "check.h"

enum { RIM = 12 };

static uint32_t cancel(void *user, float fraction, const char *stage) {
    (void)user;
    (void)fraction;
    (void)stage;
    return RLV_PROGRESS_CANCEL;
}

static RlvTissueMaterial gel(void) {
    RlvTissueMaterial material = RLV_TISSUE_MATERIAL_INIT;
    material.name = "gel";
    material.young = 8000.0f;
    material.poisson = 0.45f;
    return material;
}

/* A block of 0.1 m of which two thirds are a muscle of rings, held on the bone below, with a skin bound to it. */
static void build(RlvContext context) {
    RlvMesh box = check_box(context, 0.0f, 0.1f, 0.0f, 0.1f), untouched = {77};
    RlvTissueMaterial materials[3] = {gel(), RLV_TISSUE_MATERIAL_INIT, RLV_TISSUE_MATERIAL_INIT};
    RlvTissueVolume volumes[2] = {RLV_TISSUE_VOLUME_INIT, RLV_TISSUE_VOLUME_INIT};
    RlvTissueSurface surfaces[2] = {RLV_TISSUE_SURFACE_INIT, RLV_TISSUE_SURFACE_INIT};
    RlvTissueLayer layer = RLV_TISSUE_LAYER_INIT;
    RlvTissueDescription description = RLV_TISSUE_DESCRIPTION_INIT;
    RlvTissueReport report = RLV_TISSUE_REPORT_INIT;
    RlvTissueInfo info = RLV_TISSUE_INFO_INIT, again = RLV_TISSUE_INFO_INIT;
    RlvTissue tissue = RLV_NULL, other = RLV_NULL, refused = {77};
    double rings[3][RIM][4];
    materials[1].name = "dermis";
    materials[1].library = "dermis";
    materials[2].name = "flesh";
    materials[2].library = "muscle";
    materials[2].density = 1050.0f;
    for (int ring = 0; ring < 3; ++ring) {
        for (int at = 0; at < RIM; ++at) {
            const double angle = 6.283185307179586 * at / RIM;
            rings[ring][at][0] = 0.02 + 0.03 * ring;
            rings[ring][at][1] = 0.05 + 0.03 * cos(angle);
            rings[ring][at][2] = 0.05 + 0.03 * sin(angle);
            rings[ring][at][3] = 1.0;
        }
    }
    volumes[0].name = "block";
    volumes[0].mesh = box;
    volumes[0].has_layers = 1;
    volumes[1].name = "biceps";
    volumes[1].level = 1;
    volumes[1].material = 2;
    volumes[1].is_muscle = 1;
    volumes[1].stiffness = 100.0f;
    volumes[1].strength = 2e5f;
    volumes[1].rings = &rings[0][0][0];
    volumes[1].ring_count = 3;
    volumes[1].ring_size = RIM;
    surfaces[0].purpose = RLV_TISSUE_HOLD;
    surfaces[0].name = "bone";
    surfaces[0].mesh = check_box(context, -1.0f, 1.0f, 0.0f, 1.0f); /* its lower side looks down, as that of the block */
    surfaces[0].is_internal = 0;
    surfaces[1].purpose = RLV_TISSUE_BIND;
    surfaces[1].name = "skin";
    surfaces[1].mesh = box;
    layer.material = 1;
    layer.thickness = 0.0125f;
    description.cell[0] = description.cell[1] = description.cell[2] = 0.0125f;
    description.materials = materials;
    description.material_count = 3;
    description.volumes = volumes;
    description.volume_count = 2;
    description.surfaces = surfaces;
    description.surface_count = 2;
    description.skin = box;
    description.layers = &layer;
    description.layer_count = 1;
    CHECK_OK(rlv_tissue_build(context, &description, NULL, NULL, &report, &tissue));
    CHECK(report.voxels[0] == 8 && report.voxels[1] == 8 && report.voxels[2] == 8);
    CHECK_NEAR(report.volume, 1e-3, 1e-9);
    CHECK_OK(rlv_tissue_info(tissue, &info));
    CHECK(info.element_count == 512 && info.node_count == 729 && info.has_cells == 1 && info.muscle_count == 1);
    CHECK(info.bound_count == 1 && info.material_count == 3 && info.set_count == 7);
    CHECK_NEAR(info.high[2], 0.1f, 1e-6);

    /* The element in the middle is muscle, one at the rim dermis. */
    uint32_t *corners = malloc(512 * 8 * sizeof *corners), *main_materials = malloc(512 * sizeof *main_materials);
    float *nodes = malloc(729 * 12);
    CHECK(corners != NULL && main_materials != NULL && nodes != NULL);
    CHECK_OK(rlv_tissue_get_elements(tissue, corners, main_materials, 512));
    CHECK_OK(rlv_tissue_get_nodes(tissue, nodes, 729, 0));
    size_t counts[3] = {0, 0, 0};
    for (size_t element = 0; element < 512; ++element) {
        const float *low = nodes + 3 * corners[8 * element], *high = nodes + 3 * corners[8 * element + 6];
        CHECK(high[0] > low[0] && high[1] > low[1] && high[2] > low[2]);
        counts[main_materials[element]] += 1;
    }
    CHECK(counts[0] > 0 && counts[1] > 200 && counts[2] > 30);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_get_nodes(tissue, nodes, 728, 0), "room for 728");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_get_elements(tissue, corners, NULL, 511), "room for 511");
    free(corners);
    free(main_materials);
    free(nodes);

    RlvTissueMuscle muscle = RLV_TISSUE_MUSCLE_INIT;
    RlvTissueSet set = RLV_TISSUE_SET_INIT;
    uint32_t index = 77, bone[81];
    CHECK_OK(rlv_tissue_find_muscle(tissue, "biceps", &index));
    CHECK_OK(rlv_tissue_muscle(tissue, index, &muscle));
    CHECK(index == 0 && muscle.strength == 2e5f && strcmp(muscle.name, "biceps") == 0);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_muscle(tissue, 1, &muscle), "does not exist");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_find_muscle(tissue, "triceps", &index), "biceps");
    CHECK_OK(rlv_tissue_find_set(tissue, "bone", &index));
    CHECK_OK(rlv_tissue_set(tissue, index, &set));
    CHECK(set.count == 81 && strcmp(set.name, "bone") == 0);
    CHECK_OK(rlv_tissue_get_set(tissue, index, bone, 81));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_get_set(tissue, index, bone, 80), "room for 80");

    /* Files: what is written is read. */
    CHECK_OK(rlv_tissue_write(tissue, "tissue_test.rtissue"));
    CHECK_OK(rlv_tissue_read(context, "tissue_test.rtissue", &other));
    CHECK_OK(rlv_tissue_info(other, &again));
    CHECK(again.checksum == info.checksum && again.bound_count == 1);
    check_idle(other.id, "tissue");
    CHECK_OK(rlv_tissue_release(other));
    RlvBytes bytes = RLV_NULL;
    const uint8_t *data = NULL;
    size_t size = 0;
    CHECK_OK(rlv_tissue_write_bytes(tissue, &bytes));
    CHECK_OK(rlv_bytes_get(bytes, &data, &size));
    CHECK_OK(rlv_tissue_read_bytes(context, data, size, &other));
    CHECK_OK(rlv_tissue_info(other, &again));
    CHECK(again.checksum == info.checksum && again.bound_count == 1);
    CHECK_OK(rlv_tissue_release(other));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_read_bytes(context, data, size - 1, &refused), "bytes");
    CHECK_OK(rlv_bytes_release(bytes));
    CHECK_OK(rlv_tissue_write(tissue, "tissue_test.inp"));
    CHECK_OK(rlv_tissue_read(context, "tissue_test.inp", &other));
    CHECK_OK(rlv_tissue_info(other, &again));
    CHECK(again.element_count == 512 && again.muscle_count == 0);
    CHECK_OK(rlv_tissue_release(other));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_tissue_read(context, "no_such.rtissue", &refused), "no_such");

    /* Bent about two axes, lines of the skin through the origin are arcs. */
    description.surfaces = &surfaces[1];
    description.surface_count = 1;
    description.bend[0] = 0.5;
    description.bend[1] = 0.6;
    CHECK_OK(rlv_tissue_build(context, &description, NULL, NULL, NULL, &other));
    CHECK_OK(rlv_tissue_info(other, &again));
    CHECK(again.element_count == 512 && again.has_cells == 0);
    CHECK_NEAR(again.high[0], 0.5 * sin(0.1 / 0.5), 1e-6);
    CHECK_NEAR(again.high[2], 0.6 * sin(0.1 / 0.6), 1e-6);
    CHECK_OK(rlv_tissue_release(other));
    description.bend[1] = -1.0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, &refused), "bend");
    description.bend[0] = 0.05;
    description.bend[1] = 0.05;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, &refused), "too far");
    description.bend[0] = description.bend[1] = 0.0;
    description.surfaces = surfaces;
    description.surface_count = 2;

    /* As a job it is the same, to the bit. */
    RlvJob job = RLV_NULL;
    CHECK_OK(rlv_job_tissue_build(context, &description, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_tissue(job, &other));
    CHECK_OK(rlv_job_tissue_report(job, &report));
    CHECK_OK(rlv_tissue_info(other, &again));
    CHECK(again.checksum == info.checksum && report.voxels[2] == 8);
    CHECK_OK(rlv_tissue_release(other));
    CHECK_OK(rlv_job_release(job));

    /* The muscle pulls the skin; the bone holds. */
    RlvTissueSimulation simulation = RLV_NULL;
    RlvTissueOptions options = RLV_TISSUE_OPTIONS_INIT;
    RlvTissueRelaxation rest = RLV_TISSUE_RELAXATION_INIT;
    RlvMesh skin = RLV_NULL;
    float points[24], stretches[512], positions[729 * 3];
    RlvTissueArrays arrays = RLV_TISSUE_ARRAYS_INIT;
    const double time = 0.0;
    const float half = 0.5f, whole = 1.5f;
    options.gravity[2] = 0.0f;
    CHECK_OK(rlv_tissue_simulate(tissue, &options, &simulation));
    CHECK_OK(rlv_tissue_simulation_activate(simulation, 0, &time, &half, 1));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_activate(simulation, 0, &time, &whole, 1), "0 to 1");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_activate(simulation, 1, &time, &half, 1), "does not exist");
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_tissue_simulation_relax(simulation, 1e-2f, 2000, cancel, NULL, NULL), "");
    CHECK_OK(rlv_tissue_simulation_relax(simulation, 1e-2f, 2000, NULL, NULL, &rest));
    CHECK(rest.is_at_rest == 1 && rest.largest > 0.0f);
    arrays.element_count = 512;
    arrays.fibre_stretches = stretches;
    arrays.node_count = 729;
    arrays.positions = positions;
    CHECK_OK(rlv_tissue_simulation_get(simulation, &arrays));
    float least = 1.0f;
    for (size_t element = 0; element < 512; ++element) {
        least = stretches[element] < least ? stretches[element] : least;
    }
    CHECK(least < 0.995f);
    for (size_t node = 0; node < 81; ++node) {
        CHECK_NEAR(positions[3 * bone[node] + 2], 0.0, 1e-6);
    }
    CHECK_OK(rlv_tissue_simulation_get_bound(simulation, 0, points, 8, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_get_bound(simulation, 0, points, 7, 0), "room for 7");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_get_bound(simulation, 1, points, 8, 0), "does not exist");
    CHECK_OK(rlv_tissue_simulation_mesh(simulation, 0, &skin));
    CHECK_OK(rlv_mesh_find_attribute(skin, "velocity", &index));
    CHECK_OK(rlv_mesh_release(skin));
    arrays.node_count = 728;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_get(simulation, &arrays), "room for 728");
    check_idle(simulation.id, "tissue simulation");
    CHECK_OK(rlv_tissue_simulation_release(simulation));

    /* Refusals name what is wrong. */
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_tissue_build(context, &description, cancel, NULL, NULL, &refused), "");
    volumes[0].material = 9;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, &refused), "block");
    volumes[0].material = 0;
    volumes[1].ring_size = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, &refused), "biceps");
    volumes[1].ring_size = RIM;
    volumes[1].is_muscle = 0;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, &refused), "no muscle");
    volumes[1].is_muscle = 1;
    surfaces[1].purpose = 9;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, &refused), "purpose");
    surfaces[1].purpose = RLV_TISSUE_BIND;
    volumes[0].mesh = check_plane(context, 2, 2);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, &refused), "open");
    CHECK_OK(rlv_mesh_release(volumes[0].mesh));
    volumes[0].mesh = box;
    materials[1].library = "concrete";
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_tissue_build(context, &description, &job), "dermis");
    materials[1].library = NULL;
    materials[1].struct_size = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, &refused), "struct_size");
    description.materials = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, &refused), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, NULL, NULL, NULL, NULL, &refused), "NULL");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_build(context, &description, NULL, NULL, NULL, NULL), "NULL");
    CHECK(refused.id == 77 && untouched.id == 77);
    CHECK_OK(rlv_tissue_release(tissue));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_info(tissue, &info), "tissue");
    CHECK_OK(rlv_mesh_release(surfaces[0].mesh));
    CHECK_OK(rlv_mesh_release(box));
    remove("tissue_test.rtissue");
    remove("tissue_test.inp");
}

/* A block of 0.2 x 0.1 x 0.1 m that stands on its lower face. */
static RlvTissue block(RlvContext context) {
    const double low[3] = {0.0, 0.0, 0.0};
    const float cell[3] = {0.025f, 0.025f, 0.025f};
    const uint32_t counts[3] = {8, 4, 4}, nothing[3] = {8, 0, 4}, huge[3] = {1000, 1000, 1000};
    const RlvTissueMaterial material = gel();
    RlvTissue tissue = RLV_NULL, untouched = {77};
    CHECK_OK(rlv_tissue_block(context, low, cell, counts, &material, &tissue));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_block(context, low, cell, nothing, &material, &untouched), "1 or more");
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_tissue_block(context, low, cell, huge, &material, &untouched), "memory limit");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_block(context, NULL, cell, counts, &material, &untouched), "NULL");
    const double beyond[3] = {0, 1e300, 0};
    CHECK(rlv_tissue_block(context, beyond, cell, counts, &material, &untouched) == RLV_ERROR_INVALID);
    CHECK(untouched.id == 77);
    return tissue;
}

static void simulate(RlvContext context) {
    RlvTissue tissue = block(context);
    RlvTissueOptions options = RLV_TISSUE_OPTIONS_INIT;
    RlvTissueSimulationInfo info = RLV_TISSUE_SIMULATION_INFO_INIT;
    RlvTissueSimulation simulation = RLV_NULL, other = RLV_NULL, untouched = {77};
    RlvTissueEnergies energies = RLV_TISSUE_ENERGIES_INIT;
    RlvTissueArrays arrays = RLV_TISSUE_ARRAYS_INIT;
    uint32_t lowest = 77, highest = 77, nodes[45], tops[45];
    const double low[3] = {-1.0, -1.0, -0.001}, high[3] = {1.0, 1.0, 0.001};
    const double high_low[3] = {-1.0, -1.0, 0.0999}, high_high[3] = {1.0, 1.0, 0.101};
    CHECK_OK(rlv_tissue_add_set(tissue, "low", low, high, &lowest));
    CHECK_OK(rlv_tissue_add_set(tissue, "high", high_low, high_high, &highest));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_add_set(tissue, "low", low, high, &lowest), "already");
    CHECK_OK(rlv_tissue_get_set(tissue, lowest, nodes, 45));
    CHECK_OK(rlv_tissue_get_set(tissue, highest, tops, 45));
    CHECK_OK(rlv_tissue_hold(tissue, nodes, 45, 0, 7));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_hold(tissue, nodes, 45, 0, 8), "axes");
    const uint32_t far_off = 5000;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_hold(tissue, &far_off, 1, 0, 7), "5000");

    options.step = 1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulate(tissue, &options, &untouched), "longer than the stable one");
    options.step = 0.0f;
    options.damping = -1.0f;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulate(tissue, &options, &untouched), "damping");
    options.damping = 5.0f;
    options.halvings = 4;
    options.self_friction = 0.2f;
    CHECK_OK(rlv_tissue_simulate(tissue, &options, &simulation));
    CHECK_OK(rlv_tissue_simulate(tissue, &options, &other));
    CHECK_OK(rlv_tissue_simulation_step(simulation, 20));
    CHECK_OK(rlv_tissue_simulation_info(simulation, &info));
    CHECK(info.steps == 20 && info.step > 0.0f && info.step < info.stable_step && info.added_mass == 0.0f);
    CHECK_NEAR(info.seconds, 20.0 * info.step, 1e-9);
    CHECK_OK(rlv_tissue_simulation_energies(simulation, &energies));
    CHECK(energies.kinetic > 0.0 && energies.potential < 0.0);

    /* A state that is kept goes on to the same bits, as a job as well. */
    float here[225 * 3], there[225 * 3], speeds[225 * 3];
    RlvBytes state = RLV_NULL;
    const uint8_t *data = NULL;
    size_t size = 0;
    CHECK_OK(rlv_tissue_simulation_save_bytes(simulation, &state));
    CHECK_OK(rlv_bytes_get(state, &data, &size));
    CHECK_OK(rlv_tissue_simulation_restore_bytes(other, data, size));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_restore_bytes(other, data, size / 2), "bytes");
    CHECK_OK(rlv_bytes_release(state));
    CHECK_OK(rlv_tissue_simulation_save(simulation, "tissue_test.rtstate"));
    CHECK_OK(rlv_tissue_simulation_restore(other, "tissue_test.rtstate"));
    CHECK_OK(rlv_tissue_simulation_advance(simulation, 0.01, NULL, NULL));
    RlvJob job = RLV_NULL;
    CHECK_OK(rlv_job_tissue_advance(other, 0.01, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_result(job));
    CHECK_OK(rlv_job_release(job));
    arrays.node_count = 225;
    arrays.positions = here;
    arrays.velocities = speeds;
    CHECK_OK(rlv_tissue_simulation_get(simulation, &arrays));
    arrays.positions = there;
    CHECK_OK(rlv_tissue_simulation_get(other, &arrays));
    CHECK(memcmp(here, there, sizeof here) == 0);
    CHECK_OK(rlv_tissue_simulation_info(other, &info));
    CHECK(info.seconds >= 0.01 + 20.0 * info.step - 1e-9 && info.halved == 0);
    CHECK_FAILS(RLV_ERROR_CANCELLED, rlv_tissue_simulation_advance(other, 0.01, cancel, NULL), "");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_advance(other, -1.0, NULL, NULL), "seconds");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_job_tissue_advance(other, -1.0, &job), "seconds");
    CHECK_OK(rlv_tissue_simulation_release(other));

    /* A pressure, a drive, a load and colliders; stresses. */
    const double times[2] = {0.0, 0.01}, back[2] = {0.01, 0.0};
    const float pressures[2] = {0.0f, 100.0f};
    const float paths[6] = {0.0f, 0.0f, 0.0f, 0.002f, 0.0f, 0.0f};
    RlvTissueCollider collider = RLV_TISSUE_COLLIDER_INIT;
    CHECK_OK(rlv_tissue_simulate(tissue, NULL, &other));
    CHECK_FAILS(RLV_ERROR_NOT_FOUND, rlv_tissue_simulation_restore(other, "no_such.rtstate"), "no_such");
    CHECK_OK(rlv_tissue_simulation_press(other, tops, 45, times, pressures, 2));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_press(other, tops, 3, times, pressures, 2), "no outer face");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_press(other, tops, 45, back, pressures, 2), "order of time");
    CHECK_OK(rlv_tissue_simulation_drive(other, nodes, 45, 1, times, paths, 2));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_drive(other, &far_off, 1, 1, times, paths, 2), "5000");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_drive(other, nodes, 45, 0, times, paths, 2), "axes");
    memset(speeds, 0, sizeof speeds);
    CHECK_OK(rlv_tissue_simulation_load(other, speeds, 225, 0));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_load(other, speeds, 224, 0), "224");
    collider.body = RLV_TISSUE_BALL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_add_collider(other, &collider), "radius");
    collider.radius = 0.03f;
    collider.times = times;
    collider.translations = paths;
    collider.key_count = 2;
    CHECK_OK(rlv_tissue_simulation_add_collider(other, &collider));
    collider.body = 9;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_add_collider(other, &collider), "body");
    collider.body = RLV_TISSUE_MESH;
    collider.mesh = check_box(context, 0.5f, 0.6f, 0.0f, 0.1f);
    CHECK_OK(rlv_tissue_simulation_add_collider(other, &collider));
    CHECK_OK(rlv_mesh_release(collider.mesh));
    CHECK_OK(rlv_tissue_simulation_advance(other, 0.01, NULL, NULL));
    float stresses[128 * 6], principal[128 * 3], von_mises[128], volumes[128];
    float strains[128 * 6], principal_strains[128 * 3], contact_pressures[225];
    memset(&arrays, 0, sizeof arrays);
    arrays.struct_size = sizeof arrays;
    arrays.element_count = 128;
    arrays.stresses = stresses;
    arrays.principal_stresses = principal;
    arrays.von_mises = von_mises;
    arrays.volumes = volumes;
    arrays.strains = strains;
    arrays.principal_strains = principal_strains;
    CHECK_OK(rlv_tissue_simulation_get(other, &arrays));
    arrays.contact_pressures = contact_pressures;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_get(other, &arrays), "node_count");
    arrays.node_count = 225;
    CHECK_OK(rlv_tissue_simulation_get(other, &arrays));
    for (size_t node = 0; node < 225; ++node) {
        CHECK(contact_pressures[node] >= 0.0f && contact_pressures[node] < 1e6f);
    }
    for (size_t element = 0; element < 128; ++element) {
        const float *p = principal_strains + 3 * element, *e = strains + 6 * element;
        CHECK(p[0] >= p[1] && p[1] >= p[2]);
        CHECK_NEAR(p[0] + p[1] + p[2], e[0] + e[1] + e[2], 1e-5);
    }
    for (size_t element = 0; element < 128; ++element) {
        const float *p = principal + 3 * element, *s = stresses + 6 * element;
        CHECK(p[0] >= p[1] && p[1] >= p[2] && volumes[element] > 0.5f);
        CHECK_NEAR(p[0] + p[1] + p[2], s[0] + s[1] + s[2], 1e-3 * (fabs(p[0]) + fabs(p[2]) + 1.0));
        const double a = p[0] - p[1], b = p[1] - p[2], c = p[2] - p[0];
        CHECK_NEAR(sqrt(0.5 * (a * a + b * b + c * c)), von_mises[element], 1e-3 * von_mises[element] + 1e-3);
    }
    CHECK_OK(rlv_tissue_simulation_write_vtu(other, "tissue_test.vtu"));
    remove("tissue_test.vtu");
    remove("tissue_test.rtstate");
    CHECK_OK(rlv_tissue_simulation_release(other));
    CHECK_OK(rlv_tissue_simulation_release(simulation));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_simulation_step(simulation, 1), "tissue simulation");
    CHECK_OK(rlv_tissue_release(tissue));
}

/* A block of labels: a grid of values becomes a model, and that a grid of labels again. */
static void grids(RlvContext context) {
    if (rlv_grid_available() != RLV_OK) {
        return;
    }
    RlvMesh box = check_box(context, 0.1f, 0.3f, 0.1f, 0.3f);
    RlvGridSettings settings = RLV_GRID_SETTINGS_INIT;
    RlvTissueMaterial material = gel();
    RlvTissueLabel inside = RLV_TISSUE_LABEL_INIT;
    RlvTissueLabels labels = RLV_TISSUE_LABELS_INIT;
    RlvTissueReport report = RLV_TISSUE_REPORT_INIT;
    RlvTissueInfo info = RLV_TISSUE_INFO_INIT;
    RlvTissueSimulation simulation = RLV_NULL;
    RlvTissue tissue = RLV_NULL, again = RLV_NULL, untouched = {77};
    RlvGrid grid = RLV_NULL;
    settings.voxel = 0.01f;
    CHECK_OK(rlv_grid_from_mesh(box, &settings, NULL, NULL, &grid));
    inside.low = -1e9f;
    labels.block = 2;
    labels.materials = &material;
    labels.material_count = 1;
    labels.labels = &inside;
    labels.label_count = 1;
    CHECK_OK(rlv_tissue_from_grid(grid, &labels, &report, &tissue));
    CHECK_NEAR(report.volume, 0.008, 0.0013);
    CHECK_OK(rlv_tissue_info(tissue, &info));
    CHECK_NEAR(info.low[0], 0.1f, 0.021f);
    CHECK_NEAR(info.high[0], 0.3f, 0.021f);
    inside.material = 1;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_tissue_from_grid(grid, &labels, NULL, &untouched), "material 1");
    CHECK_OK(rlv_grid_release(grid));

    CHECK_OK(rlv_tissue_simulate(tissue, NULL, &simulation));
    CHECK_OK(rlv_tissue_simulation_write_vdb(simulation, "tissue_test.vdb"));
    CHECK_OK(rlv_grid_read(context, "tissue_test.vdb", "material", NULL, NULL, NULL, &grid));
    inside.material = 0;
    inside.low = inside.high = 1.0f;
    labels.block = 1;
    CHECK_OK(rlv_tissue_from_grid(grid, &labels, NULL, &again));
    RlvTissueInfo other = RLV_TISSUE_INFO_INIT;
    CHECK_OK(rlv_tissue_info(again, &other));
    CHECK(other.element_count == info.element_count && other.node_count == info.node_count);
    CHECK_NEAR(other.low[2], info.low[2], 1e-6);
    CHECK_NEAR(other.cell[0], info.cell[0], 1e-6);
    CHECK(untouched.id == 77);
    remove("tissue_test.vdb");
    CHECK_OK(rlv_grid_release(grid));
    CHECK_OK(rlv_tissue_simulation_release(simulation));
    CHECK_OK(rlv_tissue_release(tissue));
    CHECK_OK(rlv_tissue_release(again));
    CHECK_OK(rlv_mesh_release(box));
}

int main(void) {
    RlvContext context = RLV_NULL;
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    options.memory_limit = (uint64_t)1 << 30;
    CHECK_OK(rlv_context_create(&options, &context));
    build(context);
    simulate(context);
    grids(context);
    CHECK_OK(rlv_context_release(context));
    return 0;
}
