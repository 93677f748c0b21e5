/* An allocator of the host: it gives all memory of the library, bytes that are handed out too, gets every block back with the
 * size and alignment that it was asked for with, and what it refuses fails. */
#include "check.h"

#include <pthread.h>

/* In front of every block. */
typedef struct Head {
    void *start;
    size_t size, alignment;
    uint64_t magic;
} Head;

static const uint64_t MAGIC = 0x5245434c49455645;
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static long long bytes, blocks, most_bytes;
static size_t largest;

static void *take(void *user, size_t size, size_t alignment) {
    char *start, *block;
    Head *head;
    CHECK(user == &lock && size > 0 && alignment > 0 && (alignment & (alignment - 1)) == 0);
    if (largest != 0 && size > largest) {
        return NULL;
    }
    start = malloc(size + alignment + sizeof(Head));
    CHECK(start != NULL);
    block = start + sizeof(Head);
    block += (alignment - (uintptr_t)block % alignment) % alignment;
    head = malloc(sizeof *head);
    CHECK(head != NULL);
    head->start = start;
    head->size = size;
    head->alignment = alignment;
    head->magic = MAGIC;
    memcpy(block - sizeof head, &head, sizeof head);
    pthread_mutex_lock(&lock);
    bytes += (long long)size;
    ++blocks;
    most_bytes = bytes > most_bytes ? bytes : most_bytes;
    pthread_mutex_unlock(&lock);
    return block;
}

static const Head *head_of(const void *block) {
    const Head *head;
    memcpy(&head, (const char *)block - sizeof head, sizeof head);
    return head;
}

static void give_back(void *user, void *block, size_t size, size_t alignment) {
    const Head *head = head_of(block);
    CHECK(user == &lock && head->magic == MAGIC && head->size == size && head->alignment == alignment);
    pthread_mutex_lock(&lock);
    bytes -= (long long)size;
    --blocks;
    pthread_mutex_unlock(&lock);
    free(head->start);
    free((void *)head);
}

/* What a host does: a mesh, its surface, an edit in a document, triangles as a job, and the bytes of a file. */
static void work(void) {
    enum { CELLS = 40 };
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDetail detail = RLV_NULL;
    RlvDocument document = RLV_NULL;
    RlvBytes file = RLV_NULL;
    RlvJob job = RLV_NULL;
    RlvLayerOptions layer = RLV_LAYER_OPTIONS_INIT;
    uint32_t id = 0;
    const uint8_t *data = NULL;
    size_t size = 0;
    options.threads = 1;
    CHECK_OK(rlv_context_create(&options, &context));
    const long long before = bytes;
    RlvMesh plane = check_plane(context, CELLS, CELLS);
    CHECK(bytes - before >= 12 * (CELLS + 1) * (CELLS + 1) + 20 * CELLS * CELLS);
    CHECK_OK(rlv_mesh_write_bytes(plane, "obj", &file));
    CHECK_OK(rlv_bytes_get(file, &data, &size));
    /* The bytes lie in a block of the host. */
    CHECK(head_of(data)->magic == MAGIC && head_of(data)->size >= size && size > 1000);
    CHECK_OK(rlv_bytes_release(file));
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    CHECK_OK(rlv_detail_create(surface, NULL, NULL, &detail));
    CHECK_OK(rlv_document_create(detail, NULL, 0, &document));
    CHECK_OK(rlv_document_begin(document, "layer"));
    CHECK_OK(rlv_layer_add(detail, "another", &layer, &id));
    CHECK_OK(rlv_document_end(document, NULL));
    CHECK_OK(rlv_document_undo(document, NULL));
    CHECK_OK(rlv_job_tessellate(detail, NULL, &job));
    CHECK_OK(rlv_job_wait(job, -1.0, NULL));
    CHECK_OK(rlv_job_result(job));
    CHECK_OK(rlv_job_release(job));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    /* A large array that is refused fails the call and nothing else. */
    largest = 1 << 14;
    static const float many[3 * 3000];
    const uint32_t corners[3] = {0, 1, 2};
    RlvMeshArrays arrays = RLV_MESH_ARRAYS_INIT;
    RlvMesh refused = RLV_NULL;
    arrays.points = many;
    arrays.point_count = 3000;
    arrays.corners = corners;
    arrays.corner_count = arrays.face_size = 3;
    arrays.face_count = 1;
    CHECK_FAILS(RLV_ERROR_MEMORY, rlv_mesh_create(context, &arrays, &refused), "points");
    CHECK(refused.id == 0);
    largest = 0;
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
}

/* Returns what the library says that it occupies. */
static long long occupied(void) {
    RlvAllocatorInfo info = RLV_ALLOCATOR_INFO_INIT;
    CHECK_OK(rlv_allocator_info(&info));
    CHECK(info.is_set == 1);
    return (long long)info.bytes;
}

/* A limit bounds all meshes together, where each of them has room alone, and lets as many be made as fit. */
static void bound(void) {
    enum { SIDE = 200, ROOM = 5, MORE = 12 };
    RlvContext contexts[2] = {RLV_NULL, RLV_NULL};
    RlvContextOptions options = RLV_CONTEXT_OPTIONS_INIT;
    RlvAllocatorInfo info = RLV_ALLOCATOR_INFO_INIT;
    RlvMesh meshes[MORE];
    options.threads = 1;
    options.memory_limit = 1 << 23;
    CHECK_OK(rlv_context_create(&options, &contexts[0]));
    CHECK_OK(rlv_context_create(&options, &contexts[1]));
    /* A mesh in bytes, so that nothing of the test but its arrays takes memory. */
    RlvMesh plane = check_plane(contexts[0], SIDE, SIDE);
    RlvBytes file = RLV_NULL;
    const uint8_t *data = NULL;
    size_t size = 0;
    CHECK_OK(rlv_mesh_write_bytes(plane, "ply", &file));
    CHECK_OK(rlv_bytes_get(file, &data, &size));
    CHECK_OK(rlv_mesh_release(plane));
    const long long before = occupied();
    CHECK_OK(rlv_mesh_read_bytes(contexts[0], "ply", data, size, &plane));
    const long long one = occupied() - before;
    CHECK(one > 12 * (SIDE + 1) * (SIDE + 1) + 20 * SIDE * SIDE);
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_allocator_set_limit((uint64_t)(before + ROOM * one)));
    int count = 0;
    for (; count < MORE; ++count) {
        const RlvResult made = rlv_mesh_read_bytes(contexts[count % 2], "ply", data, size, &meshes[count]);
        if (made != RLV_OK) {
            CHECK(made == RLV_ERROR_MEMORY);
            break;
        }
        CHECK(occupied() <= before + ROOM * one);
    }
    CHECK(count >= 2 && count <= ROOM);
    CHECK_OK(rlv_allocator_info(&info));
    CHECK(info.limit == (uint64_t)(before + ROOM * one));
    /* A refused call left nothing; what is released makes room again. */
    CHECK(occupied() - before <= count * one + 4096);
    CHECK_OK(rlv_mesh_release(meshes[--count]));
    CHECK_OK(rlv_mesh_read_bytes(contexts[0], "ply", data, size, &meshes[count++]));
    /* A limit below what is occupied takes nothing back. */
    CHECK_OK(rlv_allocator_set_limit(1));
    CHECK(rlv_mesh_read_bytes(contexts[0], "ply", data, size, &plane) == RLV_ERROR_MEMORY);
    RlvMeshInfo about = RLV_MESH_INFO_INIT;
    CHECK_OK(rlv_mesh_info(meshes[0], &about));
    CHECK(about.face_count == SIDE * SIDE);
    CHECK_OK(rlv_allocator_set_limit(0));
    for (; count > 0; --count) {
        CHECK_OK(rlv_mesh_release(meshes[count - 1]));
    }
    CHECK_OK(rlv_bytes_release(file));
    CHECK_OK(rlv_context_release(contexts[0]));
    CHECK_OK(rlv_context_release(contexts[1]));
}

int main(void) {
    RlvAllocator allocator = RLV_ALLOCATOR_INIT;
    RlvAllocator empty = RLV_ALLOCATOR_INIT;
    allocator.allocate = take;
    allocator.free = give_back;
    allocator.user = &lock;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_allocator_set(NULL), "allocator");
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_allocator_set(&empty), "allocate");
    empty.allocate = take;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_allocator_set(&empty), "free");
    empty.struct_size = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_allocator_set(&empty), "struct_size");
    CHECK(blocks == 0);
    RlvAllocatorInfo info = RLV_ALLOCATOR_INFO_INIT;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_allocator_info(NULL), "RlvAllocatorInfo");
    CHECK_OK(rlv_allocator_info(&info));
    CHECK(info.is_set == 0 && info.limit == 0);
    const long long early = (long long)info.bytes;
    CHECK_OK(rlv_allocator_set(&allocator));
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_allocator_set(&allocator), "is set");
    work();
    /* What stays is for the process: a second round leaves no more. */
    const long long kept = bytes;
    CHECK(most_bytes > 100000 && kept < most_bytes / 2);
    work();
    work();
    CHECK(bytes <= kept + 4096);
    bound();
    /* It counts what the host does, and the few blocks from before. */
    CHECK(occupied() - bytes >= 0 && occupied() - bytes <= early);
    return 0;
}
