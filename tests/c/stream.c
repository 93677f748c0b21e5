/* Streams: a document in the memory of the host, which fails at every call once, or at each Nth one where N is the argument. */
#include "check.h"

#include <stdlib.h>

typedef struct Store {
    uint8_t bytes[1 << 20];
    size_t length;
    int calls;  /* until one fails, -1 for never */
    int closed;
    int synced;
} Store;

static int fails(Store *store) { return store->calls >= 0 && store->calls-- == 0; }

static uint32_t store_read(void *user, uint64_t place, uint8_t *bytes, size_t size) {
    Store *store = (Store *)user;
    CHECK(place <= store->length && size <= store->length - place && size > 0);
    if (fails(store)) {
        return 5;
    }
    memcpy(bytes, store->bytes + place, size);
    return 0;
}

static uint32_t store_write(void *user, uint64_t place, const uint8_t *bytes, size_t size) {
    Store *store = (Store *)user;
    CHECK(place <= store->length && place + size <= sizeof store->bytes && size > 0);
    const int failing = fails(store);
    /* A host that fails may have written a part. */
    const size_t written = failing ? size / 2 : size;
    memcpy(store->bytes + place, bytes, written);
    if (place + written > store->length) {
        store->length = (size_t)place + written;
    }
    return failing ? 28 : 0;
}

static uint32_t store_length(void *user, uint64_t *length) {
    Store *store = (Store *)user;
    *length = store->length;
    return fails(store) ? 6 : 0;
}

static uint32_t store_cut(void *user, uint64_t length) {
    Store *store = (Store *)user;
    CHECK(length <= store->length);
    if (fails(store)) {
        return 7;
    }
    store->length = (size_t)length;
    return 0;
}

static uint32_t store_sync(void *user) {
    Store *store = (Store *)user;
    ++store->synced;
    return fails(store) ? 8 : 0;
}

static void store_close(void *user) { ++((Store *)user)->closed; }

static RlvStream stream_of(Store *store) {
    RlvStream stream = RLV_STREAM_INIT;
    stream.user = store;
    stream.read = store_read;
    stream.write = store_write;
    stream.length = store_length;
    stream.cut = store_cut;
    stream.sync = store_sync;
    stream.close = store_close;
    store->closed = store->synced = 0;
    store->calls = -1;
    return stream;
}

static RlvDetail plate(RlvSurface surface) {
    RlvDetailOptions options = RLV_DETAIL_OPTIONS_INIT;
    RlvDetail detail = RLV_NULL;
    options.tile_size = 16;
    CHECK_OK(rlv_detail_create(surface, &options, NULL, &detail));
    return detail;
}

/* Begins an edit, dents and ends it; the first failure of these. */
static RlvResult edited(RlvContext context, RlvDetail detail, RlvDocument document, double row) {
    const RlvResult begun = rlv_document_begin(document, "a dent");
    if (begun != RLV_OK) {
        return begun;
    }
    check_dent(context, detail, row);
    return rlv_document_end(document, NULL);
}

static size_t undo_count(RlvDocument document) {
    RlvDocumentInfo info = RLV_DOCUMENT_INFO_INIT;
    CHECK_OK(rlv_document_info(document, &info));
    return info.undo_count;
}

static size_t undo_count_of(RlvSurface surface, Store *store) {
    RlvStream stream = stream_of(store);
    RlvDetail detail = plate(surface);
    RlvDocument document = RLV_NULL;
    CHECK_OK(rlv_document_open_stream(detail, &stream, 0, &document));
    const size_t count = undo_count(document);
    CHECK_OK(rlv_document_release(document));
    CHECK(store->closed == 1);
    CHECK_OK(rlv_detail_release(detail));
    return count;
}

int main(int argument_count, char **arguments) {
    const int step = argument_count > 1 ? atoi(arguments[1]) : 1;
    static Store store, other, copy;
    RlvContext context = RLV_NULL;
    RlvSurface surface = RLV_NULL;
    RlvDocument document = RLV_NULL, refused = {77};
    RlvBytes bytes = RLV_NULL;
    const uint8_t *data = NULL;
    size_t size = 0;
    CHECK_OK(rlv_context_create(NULL, &context));
    RlvMesh plane = check_plane(context, 3, 3);
    CHECK_OK(rlv_surface_create(context, plane, NULL, &surface));
    RlvDetail detail = plate(surface);

    /* Every edit is in the stream when its call returns. */
    RlvStream stream = stream_of(&store);
    CHECK_OK(rlv_document_create_stream(detail, &stream, 0, &document));
    for (size_t k = 0; k < 3; ++k) {
        CHECK_OK(edited(context, detail, document, 0.5 + 0.7 * (double)k));
        copy = store;
        CHECK(undo_count_of(surface, &copy) == k + 1);
    }
    CHECK_OK(rlv_document_undo(document, NULL));
    CHECK_OK(rlv_document_sync(document));
    CHECK(store.synced == 1 && store.closed == 0);
    /* Saved elsewhere, edits go there. */
    RlvStream second = stream_of(&other);
    CHECK_OK(rlv_document_save_stream(document, &second));
    CHECK(store.closed == 1 && other.closed == 0);
    CHECK_OK(rlv_document_save_bytes(document, &bytes));
    CHECK_OK(rlv_bytes_get(bytes, &data, &size));
    CHECK(size == other.length && memcmp(data, other.bytes, size) == 0);
    CHECK_OK(rlv_bytes_release(bytes));
    CHECK_OK(edited(context, detail, document, 1.0));
    CHECK(other.length > size);
    CHECK_OK(rlv_document_release(document));
    CHECK(other.closed == 1 && undo_count_of(surface, &other) == 3);

    /* A stream that fails at its nth call loses no edit that was confirmed, and is closed once. */
    CHECK(step > 0);
    for (int n = 0; n < 60; n += step) {
        RlvDetail fresh = plate(surface);
        copy = other;
        stream = stream_of(&copy);
        copy.calls = n;
        document.id = 77;
        size_t confirmed = 3;
        if (rlv_document_open_stream(fresh, &stream, 0, &document) == RLV_OK) {
            for (int edit = 0; edit < 4; ++edit) {
                const RlvResult result = edited(context, fresh, document, 0.6 + 0.5 * edit);
                CHECK(result == RLV_OK || result == RLV_ERROR_IO);
                confirmed += result == RLV_OK;
            }
            CHECK(undo_count(document) == confirmed);
            CHECK_OK(rlv_document_release(document));
        } else {
            CHECK(document.id == 77 && strstr(rlv_error_last(), "callback failed with") != NULL);
        }
        CHECK(copy.closed == 1);
        CHECK_OK(rlv_detail_release(fresh));
        CHECK(undo_count_of(surface, &copy) == confirmed);
    }

    /* Refusals close what they were given. */
    stream = stream_of(&copy);
    stream.cut = NULL;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_create_stream(detail, &stream, 0, &refused), "stream.cut");
    CHECK(copy.closed == 1);
    stream = stream_of(&copy);
    CHECK(rlv_document_open_stream((RlvDetail){1}, &stream, 0, &refused) == RLV_ERROR_INVALID && copy.closed == 1);
    stream = stream_of(&copy);
    CHECK(rlv_document_save_stream(refused, &stream) == RLV_ERROR_INVALID && copy.closed == 1);
    stream = stream_of(&copy);
    copy.length = 20;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_open_stream(detail, &stream, 0, &refused), "stream");
    CHECK(copy.closed == 1 && refused.id == 77);
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_open_stream(detail, NULL, 0, &refused), "RlvStream");
    stream.struct_size = 3;
    CHECK_FAILS(RLV_ERROR_INVALID, rlv_document_create_stream(detail, &stream, 0, &refused), "struct_size");
    stream = stream_of(&copy);
    stream.close = NULL;
    stream.sync = NULL;
    CHECK_OK(rlv_document_create_stream(detail, &stream, 0, &document));
    CHECK_OK(rlv_document_sync(document));
    CHECK_OK(rlv_document_release(document));
    CHECK_OK(rlv_detail_release(detail));
    CHECK_OK(rlv_surface_release(surface));
    CHECK_OK(rlv_mesh_release(plane));
    CHECK_OK(rlv_context_release(context));
    return 0;
}
