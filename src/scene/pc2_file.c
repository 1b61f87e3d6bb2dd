// PC2 ("POINTCACHE2"), little-endian: tag[12], int32 version 1, int32 points, float32 start frame, float32
// rate, int32 samples; then xyz in float32 per point and sample.

#include "scene/output_file.h"
#include "scene/scene_error.h"

#include <errno.h>
#include <math.h>
#include <stdlib.h>
#include <string.h>

enum { TAG_BYTES = 12, HEADER_BYTES = 32, FORMAT_VERSION = 1, BLOCK_FLOATS = 3072 };

static const char file_tag[TAG_BYTES] = "POINTCACHE2";

struct PercalePc2Writer {
    PercaleOutputFile file;
    uint32_t vertex_count;
    uint32_t sample_count;
    uint32_t written; // samples
};

static uint32_t load_word(const unsigned char *bytes)
{
    return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

static void store_word(unsigned char *bytes, uint32_t word)
{
    for (int k = 0; k < 4; ++k) {
        bytes[k] = (unsigned char)(word >> (8 * k));
    }
}

static float load_float(const unsigned char *bytes)
{
    const uint32_t word = load_word(bytes);
    float value;
    memcpy(&value, &word, sizeof value);
    return value;
}

static void store_float(unsigned char *bytes, float value)
{
    uint32_t word;
    memcpy(&word, &value, sizeof word);
    store_word(bytes, word);
}

// ---- reading ----

static bool read_header(FILE *stream, const char *path, PercalePointCache *cache, PercaleSceneError *error)
{
    unsigned char header[HEADER_BYTES];
    if (fread(header, 1, sizeof header, stream) != sizeof header ||
        memcmp(header, file_tag, TAG_BYTES) != 0) {
        return percale_scene_fail(error, "%s: not a PC2 point cache", path);
    }
    const uint32_t version = load_word(header + 12);
    if (version != FORMAT_VERSION) {
        return percale_scene_fail(error, "%s: PC2 version %u, known is %d", path, version, FORMAT_VERSION);
    }
    cache->vertex_count = load_word(header + 16);
    cache->sample_count = load_word(header + 28);
    if (cache->vertex_count == 0 || cache->vertex_count > INT32_MAX || cache->sample_count == 0 ||
        cache->sample_count > INT32_MAX) {
        return percale_scene_fail(error, "%s: %d points and %d samples: nothing to read", path,
                                  (int32_t)cache->vertex_count, (int32_t)cache->sample_count);
    }
    return true;
}

// The size must be the header's, before memory is asked for in its name.
static bool check_size(FILE *stream, const char *path, const PercalePointCache *cache,
                       PercaleSceneError *error)
{
    if (fseeko(stream, 0, SEEK_END) != 0) {
        return percale_scene_fail_system(error, "cannot read", path, errno);
    }
    const uint64_t size = (uint64_t)ftello(stream);
    const double expected = HEADER_BYTES + 12.0 * cache->vertex_count * cache->sample_count;
    if ((double)size != expected) {
        return percale_scene_fail(error, "%s: %llu bytes, but %u samples of %u points take %.0f", path,
                                  (unsigned long long)size, cache->sample_count, cache->vertex_count,
                                  expected);
    }
    if (fseeko(stream, HEADER_BYTES, SEEK_SET) != 0) {
        return percale_scene_fail_system(error, "cannot read", path, errno);
    }
    return true;
}

static bool read_samples(FILE *stream, const char *path, PercalePointCache *cache, PercaleSceneError *error)
{
    const size_t per_sample = 3 * (size_t)cache->vertex_count;
    const size_t count = per_sample * cache->sample_count;
    cache->samples = malloc(count * sizeof *cache->samples);
    if (cache->samples == NULL) {
        return percale_scene_out_of_memory(error);
    }
    unsigned char block[4 * BLOCK_FLOATS];
    for (size_t first = 0; first < count; first += BLOCK_FLOATS) {
        const size_t block_count = count - first < BLOCK_FLOATS ? count - first : BLOCK_FLOATS;
        if (fread(block, 4, block_count, stream) != block_count) {
            return percale_scene_fail(error, "%s: ends early", path);
        }
        for (size_t k = 0; k < block_count; ++k) {
            const float value = load_float(block + 4 * k);
            if (!isfinite(value)) {
                return percale_scene_fail(error, "%s: sample %zu, point %zu is NaN or infinite", path,
                                          (first + k) / per_sample, (first + k) % per_sample / 3);
            }
            cache->samples[first + k] = value;
        }
    }
    return true;
}

bool percale_pc2_read(const char *path, PercalePointCache *cache, PercaleSceneError *error)
{
    *cache = (PercalePointCache){0};
    FILE *stream = fopen(path, "rbe");
    if (stream == NULL) {
        return percale_scene_fail_system(error, "cannot read", path, errno);
    }
    const bool done = read_header(stream, path, cache, error) && check_size(stream, path, cache, error) &&
                      read_samples(stream, path, cache, error);
    (void)fclose(stream);
    if (!done) {
        percale_point_cache_free(cache);
    }
    return done;
}

void percale_point_cache_free(PercalePointCache *cache)
{
    free(cache->samples);
    *cache = (PercalePointCache){0};
}

// ---- writing ----

PercalePc2Writer *percale_pc2_open(const char *path, uint32_t vertex_count, uint32_t sample_count,
                                   float sample_rate, PercaleSceneError *error)
{
    if (vertex_count == 0 || vertex_count > INT32_MAX || sample_count == 0 || sample_count > INT32_MAX) {
        percale_scene_fail(error, "%s: a PC2 file of %u points and %u samples can't be", path, vertex_count,
                           sample_count);
        return NULL;
    }
    PercalePc2Writer *writer = calloc(1, sizeof *writer);
    if (writer == NULL) {
        percale_scene_out_of_memory(error);
        return NULL;
    }
    writer->vertex_count = vertex_count;
    writer->sample_count = sample_count;
    if (!percale_output_open(&writer->file, path, error)) {
        free(writer);
        return NULL;
    }
    unsigned char header[HEADER_BYTES] = {0};
    memcpy(header, file_tag, TAG_BYTES);
    store_word(header + 12, FORMAT_VERSION);
    store_word(header + 16, vertex_count);
    store_float(header + 24, sample_rate);
    store_word(header + 28, sample_count);
    // A failed write shows in the stream's error mark when the file is committed, here and below.
    (void)fwrite(header, 1, sizeof header, writer->file.stream);
    return writer;
}

bool percale_pc2_append(PercalePc2Writer *writer, const float *positions, PercaleSceneError *error)
{
    if (writer->written == writer->sample_count) {
        return percale_scene_fail(error, "%s: more than the announced %u samples", writer->file.path,
                                  writer->sample_count);
    }
    const size_t count = 3 * (size_t)writer->vertex_count;
    unsigned char block[4 * BLOCK_FLOATS];
    for (size_t first = 0; first < count; first += BLOCK_FLOATS) {
        const size_t block_count = count - first < BLOCK_FLOATS ? count - first : BLOCK_FLOATS;
        for (size_t k = 0; k < block_count; ++k) {
            store_float(block + 4 * k, positions[first + k]);
        }
        if (fwrite(block, 4, block_count, writer->file.stream) != block_count) {
            return percale_scene_fail_system(error, "cannot write", writer->file.path, errno);
        }
    }
    ++writer->written;
    return true;
}

bool percale_pc2_close(PercalePc2Writer *writer, PercaleSceneError *error)
{
    bool done = false;
    if (writer->written == writer->sample_count) {
        done = percale_output_commit(&writer->file, error);
    } else {
        percale_scene_fail(error, "%s: %u of %u samples written, file dropped", writer->file.path,
                           writer->written, writer->sample_count);
        percale_output_discard(&writer->file);
    }
    free(writer);
    return done;
}
