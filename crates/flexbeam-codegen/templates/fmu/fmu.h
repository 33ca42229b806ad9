/* What both versions of the functional mock-up interface share: variables by their value references, one step, and a memory that
 * can be copied and written as bytes. No global state: as many instances as you like. */
#ifndef UPPER_FMU_H
#define UPPER_FMU_H

#include <stddef.h>
#include <stdint.h>

/* How far the host is. */
enum NAME_phase { UPPER_INSTANTIATED, UPPER_INITIALIZING, UPPER_STEPPING, UPPER_TERMINATED };

#include "memory.h"

/* ---- memory.c ---- */

/* As after instantiation: at rest, with the start values of modelDescription.xml. */
void NAME_memory_reset(struct NAME_memory *memory);

/* The number under a value reference; a null pointer where there is none. */
const double *NAME_number(const struct NAME_memory *memory, unsigned int variable);

/* Sets a number. false: none, none that may be set now, or a value that it cannot have; then nothing is changed. */
bool NAME_set_number(struct NAME_memory *memory, unsigned int variable, double value);

/* The whole number or enumeration under a value reference. */
bool NAME_get_whole(const struct NAME_memory *memory, unsigned int variable, int64_t *value);

/* Sets one. false: as above. */
bool NAME_set_whole(struct NAME_memory *memory, unsigned int variable, int64_t value);

/* One period with the inputs as they stand, from time_s on; its answers are the outputs at its end. */
void NAME_step(struct NAME_memory *memory, double time_s);

/* Bytes on their way, written or read; without either it counts them. */
struct NAME_stream {
    unsigned char *written;
    const unsigned char *read;
    size_t at;
    bool sound;
};

/* All of a memory through the stream, field by field. */
void NAME_memory_through(struct NAME_stream *stream, struct NAME_memory *memory);

/* ---- fmu.c ---- */

/* Whether a step has the length of the sample period, but for what a host's sum of steps rounds away. */
bool NAME_is_period(double step_s);

void NAME_stream_bits(struct NAME_stream *stream, uint64_t *value);
void NAME_stream_number(struct NAME_stream *stream, double *value);

/* The value, or what is read in its place. Outside of 0 to the largest: 0, and the stream is not sound. */
int NAME_stream_whole(struct NAME_stream *stream, int value, int largest);

/* Bytes of a memory: the same on every machine. */
size_t NAME_memory_size(void);

/* Writes as many bytes as NAME_memory_size() says. */
void NAME_memory_write(const struct NAME_memory *memory, unsigned char *bytes);

/* Reads them back. false: of another unit, of another length, or no memory at all; then nothing is changed. */
bool NAME_memory_read(struct NAME_memory *memory, const unsigned char *bytes, size_t size);

#endif
