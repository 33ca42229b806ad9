/* See fmu.h. */
#include "fmu.h"

#include <string.h>

bool NAME_is_period(double step_s)
{
    const double off = step_s - UPPER_PERIOD_S;
    return -1e-6 * UPPER_PERIOD_S <= off && off <= 1e-6 * UPPER_PERIOD_S;
}

/* ---- Bytes: every number of eight, the least significant first, behind a head that names what the unit is of ---- */

static const char head[] = "flexbeam FMU memory 1 " UPPER_SHA256;

void NAME_stream_bits(struct NAME_stream *stream, uint64_t *value)
{
    uint64_t found = 0;
    for (unsigned int k = 0; k < 8; ++k) {
        if (stream->written != NULL) {
            stream->written[stream->at + k] = (unsigned char)(*value >> (8 * k) & 255);
        }
        if (stream->read != NULL) {
            found |= (uint64_t)stream->read[stream->at + k] << (8 * k);
        }
    }
    if (stream->read != NULL) {
        *value = found;
    }
    stream->at += 8;
}

void NAME_stream_number(struct NAME_stream *stream, double *value)
{
    uint64_t found;
    memcpy(&found, value, sizeof found);
    NAME_stream_bits(stream, &found);
    memcpy(value, &found, sizeof found);
}

int NAME_stream_whole(struct NAME_stream *stream, int value, int largest)
{
    uint64_t found = (uint64_t)value;
    NAME_stream_bits(stream, &found);
    if (found > (uint64_t)largest) {
        stream->sound = false;
        return 0;
    }
    return (int)found;
}

size_t NAME_memory_size(void)
{
    struct NAME_memory any;
    struct NAME_stream stream = {NULL, NULL, sizeof head, true};
    NAME_memory_reset(&any);
    NAME_memory_through(&stream, &any);
    return stream.at;
}

void NAME_memory_write(const struct NAME_memory *memory, unsigned char *bytes)
{
    struct NAME_memory copy = *memory;
    struct NAME_stream stream = {bytes, NULL, sizeof head, true};
    memcpy(bytes, head, sizeof head);
    NAME_memory_through(&stream, &copy);
}

bool NAME_memory_read(struct NAME_memory *memory, const unsigned char *bytes, size_t size)
{
    struct NAME_memory found;
    struct NAME_stream stream = {NULL, bytes, sizeof head, true};
    if (size != NAME_memory_size() || memcmp(bytes, head, sizeof head) != 0) {
        return false;
    }
    NAME_memory_reset(&found);
    NAME_memory_through(&stream, &found);
    if (stream.sound) {
        *memory = found;
    }
    return stream.sound;
}
