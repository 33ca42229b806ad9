/* A stand-in for comedilib with one board, /dev/comedi0: the calls that flexbeam makes, with the meaning that comedilib's
 * documentation gives them. Written from the documentation; it shows that flexbeam keeps to that, not that a board does.
 *
 * Subdevices: 0 analogue input (8 channels, 16 bits, +-5 V and +-10 V), 1 analogue output (2 channels, 12 bits, +-10 V and
 * 0 to 20 V), 2 digital, 3 counter (2 channels, 24 bits). There is no watchdog. The rig behind it moves ten counts for each
 * volt at each reading of the counter.
 *
 * Functions that begin with stand_in_ are the tests' own. */

#include <errno.h>
#include <math.h>
#include <pthread.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#ifdef WITH_HEADER
#include <comedilib.h>
#else
typedef struct comedi_t_struct comedi_t;
typedef unsigned int lsampl_t;
typedef struct { double min, max; unsigned int unit; } comedi_range;
#endif

struct comedi_t_struct { int magic; };

enum { MAGIC = 0x1234, SUBDEVICES = 4, COUNTER_MAX = 0xffffff };
enum { BAD_DEVICE = 0x1002, BAD_SUBDEVICE = 0x1003, BAD_CHANNEL = 0x1004 };

#ifndef FOURTH_KIND
#define FOURTH_KIND 6
#endif

static const int kinds[SUBDEVICES] = { 1, 2, 5, FOURTH_KIND };
static const int channels[SUBDEVICES] = { 8, 2, 8, 2 };
static const lsampl_t greatest[SUBDEVICES] = { 65535, 4095, 1, COUNTER_MAX };
static comedi_range ranges[SUBDEVICES][2] = { { { -5, 5, 0 }, { -10, 10, 0 } },
                                              { { -10, 10, 0 }, { 0, 20, 0 } },
                                              { { 0, 5, 0 } },
                                              { { 0, 1, 2 } } };
static const int n_ranges[SUBDEVICES] = { 2, 2, 1, 1 };

static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;
static pthread_cond_t released = PTHREAD_COND_INITIALIZER;
static __thread int last_error;
static lsampl_t output, counter, gauge;
static unsigned output_range;
static int open_handles;
static char log_path[4096], failing[64], stalling[64];
static int failing_in, failing_errno, stalling_in;

static void note(const char *line)
{
    if (log_path[0] == 0) return;
    FILE *file = fopen(log_path, "a");
    fprintf(file, "%s\n", line);
    fclose(file);
}

static int refuse(int error)
{
    last_error = error;
    return -1;
}

static int valid(comedi_t *it, unsigned subdevice, unsigned channel)
{
    if (it == NULL || it->magic != MAGIC) return refuse(BAD_DEVICE);
    if (subdevice >= SUBDEVICES) return refuse(BAD_SUBDEVICE);
    if (channel >= (unsigned)channels[subdevice]) return refuse(BAD_CHANNEL);
    return 0;
}

/* Every reading and writing begins here, with the lock held. Others may call while it stalls. */
static int begin(const char *call, const char *line)
{
    note(line);
    if (strcmp(call, stalling) == 0 && --stalling_in == 0) {
        while (stalling[0] != 0) pthread_cond_wait(&released, &lock);
    }
    if (strcmp(call, failing) == 0 && --failing_in == 0) return refuse(failing_errno);
    return 0;
}

comedi_t *comedi_open(const char *path)
{
    char line[256];
    snprintf(line, sizeof line, "comedi_open %s", path);
    pthread_mutex_lock(&lock);
    note(line);
    comedi_t *it = NULL;
    if (strcmp(path, "/dev/comedi0") != 0) {
        refuse(ENOENT);
    } else {
        it = malloc(sizeof *it);
        it->magic = MAGIC;
        open_handles++;
    }
    pthread_mutex_unlock(&lock);
    return it;
}

int comedi_close(comedi_t *it)
{
    pthread_mutex_lock(&lock);
    note("comedi_close");
    it->magic = 0;
    free(it);
    open_handles--;
    pthread_mutex_unlock(&lock);
    return 0;
}

int comedi_get_n_subdevices(comedi_t *it) { return valid(it, 0, 0) ? -1 : SUBDEVICES; }

int comedi_find_subdevice_by_type(comedi_t *it, int type, unsigned first)
{
    if (valid(it, 0, 0)) return -1;
    for (unsigned k = first; k < SUBDEVICES; k++)
        if (kinds[k] == type) return (int)k;
    return -1;
}

int comedi_get_subdevice_type(comedi_t *it, unsigned subdevice)
{
    return valid(it, subdevice, 0) ? -1 : kinds[subdevice];
}

int comedi_get_n_channels(comedi_t *it, unsigned subdevice)
{
    return valid(it, subdevice, 0) ? -1 : channels[subdevice];
}

lsampl_t comedi_get_maxdata(comedi_t *it, unsigned subdevice, unsigned channel)
{
    return valid(it, subdevice, channel) ? 0 : greatest[subdevice];
}

int comedi_get_n_ranges(comedi_t *it, unsigned subdevice, unsigned channel)
{
    return valid(it, subdevice, channel) ? -1 : n_ranges[subdevice];
}

comedi_range *comedi_get_range(comedi_t *it, unsigned subdevice, unsigned channel, unsigned range)
{
    if (valid(it, subdevice, channel) || range >= (unsigned)n_ranges[subdevice]) return NULL;
    return &ranges[subdevice][range];
}

static double output_v(void)
{
    const comedi_range *range = &ranges[1][output_range];
    return range->min + (range->max - range->min) * output / greatest[1];
}

int comedi_data_read(comedi_t *it, unsigned subdevice, unsigned channel, unsigned range, unsigned aref, lsampl_t *data)
{
    char line[256];
    snprintf(line, sizeof line, "comedi_data_read %u.%u range %u aref %u", subdevice, channel, range, aref);
    pthread_mutex_lock(&lock);
    int code = begin("comedi_data_read", line);
    if (code == 0) code = valid(it, subdevice, channel);
    if (code == 0 && range >= (unsigned)n_ranges[subdevice]) code = refuse(EINVAL);
    if (code == 0) {
        if (kinds[subdevice] == 6) {
            *data = counter;
            counter = (counter + (lsampl_t)(int)lround(10.0 * output_v())) & COUNTER_MAX;
        } else {
            *data = gauge;
        }
        code = 1;
    }
    pthread_mutex_unlock(&lock);
    return code;
}

int comedi_data_write(comedi_t *it, unsigned subdevice, unsigned channel, unsigned range, unsigned aref, lsampl_t data)
{
    char line[256];
    snprintf(line, sizeof line, "comedi_data_write %u.%u range %u aref %u: %u", subdevice, channel, range, aref, data);
    pthread_mutex_lock(&lock);
    int code = begin("comedi_data_write", line);
    if (code == 0) code = valid(it, subdevice, channel);
    if (code == 0 && (kinds[subdevice] != 2 || data > greatest[subdevice] || range >= (unsigned)n_ranges[subdevice])) code = refuse(EINVAL);
    if (code == 0) {
        output = data;
        output_range = range;
        code = 1;
    }
    pthread_mutex_unlock(&lock);
    return code;
}

int comedi_errno(void) { return last_error; }

const char *comedi_strerror(int error)
{
    static const char *const texts[] = { "Bad comedi_t structure", "Invalid subdevice", "Invalid channel" };
    return error >= BAD_DEVICE && error <= BAD_CHANNEL ? texts[error - BAD_DEVICE] : strerror(error);
}

double comedi_to_phys(lsampl_t data, comedi_range *range, lsampl_t maxdata)
{
    if (data == 0 || data == maxdata) return NAN;
    return range->min + (range->max - range->min) * data / maxdata;
}

lsampl_t comedi_from_phys(double volts, comedi_range *range, lsampl_t maxdata)
{
    double position = (volts - range->min) / (range->max - range->min) * maxdata;
    return position < 0 ? 0 : position > maxdata ? maxdata : (lsampl_t)floor(position + 0.5);
}

void stand_in_log_path(const char *path) { snprintf(log_path, sizeof log_path, "%s", path); }

/* The nth call of this name from now on fails with this error number. */
void stand_in_fail(const char *call, int nth, int error)
{
    pthread_mutex_lock(&lock);
    snprintf(failing, sizeof failing, "%s", call);
    failing_in = nth;
    failing_errno = error;
    pthread_mutex_unlock(&lock);
}

/* The nth call of this name from now on hangs until it is released. */
void stand_in_stall(const char *call, int nth)
{
    pthread_mutex_lock(&lock);
    snprintf(stalling, sizeof stalling, "%s", call);
    stalling_in = nth;
    pthread_mutex_unlock(&lock);
}

void stand_in_release(void)
{
    pthread_mutex_lock(&lock);
    stalling[0] = 0;
    pthread_cond_broadcast(&released);
    pthread_mutex_unlock(&lock);
}

/* The gauge's volts on the range of +-10 V. */
void stand_in_sensors(int count, double volts)
{
    pthread_mutex_lock(&lock);
    counter = (lsampl_t)count & COUNTER_MAX;
    gauge = comedi_from_phys(volts, &ranges[0][1], greatest[0]);
    pthread_mutex_unlock(&lock);
}

double stand_in_output_v(void)
{
    pthread_mutex_lock(&lock);
    double volts = output_v();
    pthread_mutex_unlock(&lock);
    return volts;
}

int stand_in_open_handles(void) { return open_handles; }
