/* Ticks with their answers, computed by flexbeam's @MADE_BY@. Exact: hexadecimal floating-point numbers. */
#ifndef UPPER_TEST_VECTORS_H
#define UPPER_TEST_VECTORS_H

#include "NAME.h"

#define UPPER_VECTORS @VECTORS@
#define UPPER_VECTOR_SETTINGS @VECTOR_SETTINGS@

/* One tick: first a reset, if there is one, then NAME_tick() with settings, inputs, and what it must answer. */
struct NAME_vector {
    unsigned char settings; /* which of NAME_vector_settings */
    unsigned char reset;
    unsigned char fault;    /* enum NAME_fault */
    NAME_real inputs[3];    /* reference, theta, alpha [rad] */
    NAME_real answers[6];   /* voltage, u [V], v, y, y_model, e [rad] */
};

extern const struct NAME_settings NAME_vector_settings[UPPER_VECTOR_SETTINGS];
extern const struct NAME_vector NAME_vectors[UPPER_VECTORS];

#endif
