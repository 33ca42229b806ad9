/* See test_vectors.h. */
#include "test_vectors.h"

#include <math.h> /* INFINITY and NAN alone */

const struct NAME_settings NAME_vector_settings[UPPER_VECTOR_SETTINGS] = {
@SETTINGS@
};

/* settings, reset, fault, {reference, theta, alpha}, {voltage, u, v, y, y_model, e} */
const struct NAME_vector NAME_vectors[UPPER_VECTORS] = {
@ROWS@
};
