/* Compiles where comedilib's header is installed. */
#include <comedilib.h>
