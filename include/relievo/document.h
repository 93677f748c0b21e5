/* Relievo: documents, in which the edits of a detail are kept: undo, redo, and a journal that survives a killed host.
 *
 * A document follows a detail. What is done between rlv_document_begin and rlv_document_end is one edit, whatever it
 * is: strokes, imprints, blocks, layers; it costs what it changed. With a file, every edit is handed to the operating
 * system before rlv_document_end returns: if the host is killed then, opening the file brings every edit that was
 * ended, and says what was under way. A stream of the host takes the place of a file, and bytes that of a copy of it. Two
 * documents of one detail do not know of each other.
 *
 * All functions on a document edit its detail and return RLV_ERROR_BUSY while another edit is at work; commit the
 * detail to see what they did. */
#ifndef RELIEVO_DOCUMENT_H
#define RELIEVO_DOCUMENT_H

#include "relievo/bytes.h"
#include "relievo/detail.h"
#include "relievo/stream.h"

typedef struct RlvDocument {
    uint64_t id;
} RlvDocument;

typedef struct RlvDocumentInfo {
    uint32_t struct_size;
    uint32_t is_open;  /* 0 or 1: whether an edit was begun and not ended */
    size_t undo_count; /* edits that can be undone */
    size_t redo_count; /* edits that can be made again */
    uint64_t bytes;    /* of edits in memory; the others are in the file, or a temporary one */
} RlvDocumentInfo;

#define RLV_DOCUMENT_INFO_INIT {sizeof(RlvDocumentInfo), 0, 0, 0, 0}

/* What an edit, or its undoing, changed. */
typedef struct RlvDocumentChanges {
    uint32_t struct_size;
    uint32_t is_done;   /* 1 if there was something to undo or make again, or the edit changed something */
    size_t layer_count; /* layers of which blocks changed */
    size_t block_count; /* blocks that changed, in all of them */
    uint64_t bytes;     /* that the edit takes in the file */
} RlvDocumentChanges;

#define RLV_DOCUMENT_CHANGES_INIT {sizeof(RlvDocumentChanges), 0, 0, 0, 0}

/* How a document goes to another mesh. */
typedef struct RlvTransferOptions {
    uint32_t struct_size;
    uint32_t reserved;
    RlvMesh from; /* the mesh it was made on, where it does not hold its points or the mesh has creases; NULL handle for
                     the one in it */
    double reach; /* how far a place of the old surface may be from one of the new, object units; 0 for 2 % of the new
                     surface's extent */
} RlvTransferOptions;

#define RLV_TRANSFER_OPTIONS_INIT {sizeof(RlvTransferOptions), 0, {0}, 0.0}

/* What a transfer did. Areas are in square object units. */
typedef struct RlvTransferReport {
    uint32_t struct_size;
    uint32_t layer_count;
    double area;           /* of the new surface */
    double uncovered_area; /* of it that is further from the old one than the reach: nothing is there */
    double edited_area;    /* of the old tiles that hold something, over all layers */
    double lost_area;      /* of these that have no place on the new surface */
    double reach;          /* as it was taken */
} RlvTransferReport;

#define RLV_TRANSFER_REPORT_INIT {sizeof(RlvTransferReport), 0, 0.0, 0.0, 0.0, 0.0, 0.0}

/* Follows a detail from now on. path is the file (UTF-8), which is written at once and replaces what is there; NULL for
 * no file. memory is the bytes that edits may occupy before the oldest go to the file, or a temporary one; 0 for 256
 * MiB. Fails if the file cannot be written or another program works on it. */
RLV_API RlvResult rlv_document_create(RlvDetail detail, const char *path, uint64_t memory, RlvDocument *out);

/* Opens a file and gives the detail its layers, in place of those it has, and its history. The detail's cage must have
 * the faces that the document was made on; the message of a refusal says what differs. Notes, such as of an edit that
 * was under way when the host was killed, go to the context's log. The file is this document's alone until it is
 * released. Fails if the file cannot be read, is damaged or newer, is of another mesh, holds more than the budget of
 * the detail, or another program works on it. */
RLV_API RlvResult rlv_document_open(RlvDetail detail, const char *path, uint64_t memory, RlvDocument *out);

/* As rlv_document_create, in a stream of the host in place of a file: what is there is replaced, and every edit is written
 * before rlv_document_end returns. A host that ends within a write has a document that opens without the edit. Fails too if
 * the stream lacks a callback. */
RLV_API RlvResult rlv_document_create_stream(RlvDetail detail, const RlvStream *stream, uint64_t memory, RlvDocument *out);

/* As rlv_document_open, from a stream of the host, to which new edits are appended. The stream is this document's alone until
 * it is released; tiles that leave memory go to a temporary file. Fails too if the stream lacks a callback. */
RLV_API RlvResult rlv_document_open_stream(RlvDetail detail, const RlvStream *stream, uint64_t memory, RlvDocument *out);

/* As rlv_document_open, from size bytes that rlv_document_save_bytes made or a file holds; they are copied. New edits stay in
 * memory until the document is saved. Fails as rlv_document_open does. */
RLV_API RlvResult rlv_document_open_bytes(RlvDetail detail, const uint8_t *bytes, size_t size, uint64_t memory,
                                          RlvDocument *out);

RLV_API RlvResult rlv_document_retain(RlvDocument document);
RLV_API RlvResult rlv_document_release(RlvDocument document);

/* How many edits the document has. No failure of its own. */
RLV_API RlvResult rlv_document_info(RlvDocument document, RlvDocumentInfo *out);

/* Begins an edit. input says what it is going to be, in whatever words the host understands again; it is what the file
 * tells of an edit that was never ended. It may be NULL. Fails if one is under way. */
RLV_API RlvResult rlv_document_begin(RlvDocument document, const char *input);

/* Ends the edit: it is confirmed, and what was undone before it cannot be made again. changes may be NULL. If the file
 * cannot be written it fails, and the detail is as it was when the edit began. */
RLV_API RlvResult rlv_document_end(RlvDocument document, RlvDocumentChanges *changes);

/* Takes the edit that was begun back, as if it had not been. Fails if none is. */
RLV_API RlvResult rlv_document_abandon(RlvDocument document);

/* Undoes the last edit: every block is as it was before it, to the bit. changes may be NULL. Fails, and changes
 * nothing, if an edit is under way or the detail was edited outside of edits. */
RLV_API RlvResult rlv_document_undo(RlvDocument document, RlvDocumentChanges *changes);

/* Makes the edit that was undone last again. changes may be NULL. Fails as rlv_document_undo does. */
RLV_API RlvResult rlv_document_redo(RlvDocument document, RlvDocumentChanges *changes);

/* Writes the detail with its history to a file and keeps edits there from now on. Fails if an edit is under way or the
 * file cannot be written; edits then go to where they went. */
RLV_API RlvResult rlv_document_save(RlvDocument document, const char *path);

/* As rlv_document_save, to a stream of the host, whose bytes it replaces. Fails too if the stream lacks a callback; what the
 * stream holds is then no document. */
RLV_API RlvResult rlv_document_save_stream(RlvDocument document, const RlvStream *stream);

/* Makes bytes of the detail with its history, the same as the file that rlv_document_save writes. Edits go on to where they
 * went. Fails if an edit is under way, and with RLV_ERROR_MEMORY if there is no room. */
RLV_API RlvResult rlv_document_save_bytes(RlvDocument document, RlvBytes *out);

/* Waits until all edits are on the disk, where a failure of power does not reach them. Fails if the file cannot be
 * written. */
RLV_API RlvResult rlv_document_sync(RlvDocument document);

/* Folds the history of a file that no document has open into its layers, but for the last keep edits. What is seen
 * stays the same. The file is replaced as a whole or not at all. Fails if the file cannot be read or written, is
 * damaged, or a program works on it. */
RLV_API RlvResult rlv_document_compact(RlvContext context, const char *path, size_t keep);

/* The mesh that a document was made on, as far as the file has it: points, faces and holes, but no creases and no
 * attributes. The file may be hostile. Fails with RLV_ERROR_NOT_FOUND if it has no points. */
RLV_API RlvResult rlv_document_mesh(RlvContext context, const char *path, RlvMesh *out);

/* As rlv_document_mesh, of the size bytes of a document. Fails as that does. */
RLV_API RlvResult rlv_document_mesh_bytes(RlvContext context, const uint8_t *bytes, size_t size, RlvMesh *out);

/* Takes the layers of the document at path to mesh, which is another one, and writes them as the document at to_path: every texel
 * takes what the nearest place of the old surface that faces the same way has. Both are seen without their
 * displacement. options, progress and report may be NULL; what should be known goes to the context's log. Fails if the
 * document cannot be read or is damaged, it has no points and options name no mesh, a mesh cannot be subdivided, the
 * context's memory limit is too small, progress asks to stop, or the file cannot be written. */
RLV_API RlvResult rlv_document_transfer(RlvContext context, RlvMesh mesh, const char *path, const char *to_path,
                                        const RlvTransferOptions *options, RlvProgress progress, void *user,
                                        RlvTransferReport *report);

#endif
