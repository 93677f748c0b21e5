/* Functions of the host with the names of libraries that hosts often contain: stb_image, miniz, TinyEXR, zstd and what
 * every Rust library has. Each counts its calls; the static library must neither clash with them nor call them. */
#define OWN(name) \
    int name(void); \
    int name(void) { return ++own_calls; }

extern int own_calls;
int own_calls = 0;

OWN(stbi_load)
OWN(stbi_load_from_memory)
OWN(stbi_image_free)
OWN(stbi_failure_reason)
OWN(stbi_write_png)
OWN(stbi_write_hdr)
OWN(mz_compress)
OWN(mz_compress2)
OWN(mz_uncompress)
OWN(mz_crc32)
OWN(mz_adler32)
OWN(mz_deflateInit)
OWN(mz_inflate)
OWN(LoadEXR)
OWN(SaveEXR)
OWN(FreeEXRImage)
OWN(InitEXRHeader)
OWN(ParseEXRHeaderFromMemory)
OWN(ZSTD_compress)
OWN(ZSTD_compress2)
OWN(ZSTD_compressCCtx)
OWN(ZSTD_compressStream2)
OWN(ZSTD_createCCtx)
OWN(ZSTD_decompress)
OWN(ZSTD_decompressDCtx)
OWN(ZSTD_createDCtx)
OWN(ZSTD_isError)
OWN(rust_eh_personality)
OWN(rust_begin_unwind)
