#include <math.h>
#include <stdint.h>
#include <string.h>

/* Sine and cosine: reduction by pi/2 in three parts (Cody and Waite), polynomials of fdlibm (Sun Microsystems, 1993). */
static inline void sine_cosine(double x, double *sine, double *cosine)
{
    if (!(fabs(x) < 1.0e5)) {
        *sine = sin(x);
        *cosine = cos(x);
        return;
    }
    const double round = 6755399441055744.0;
    const double rounded = x * 0x1.45f306dc9c883p-1 + round;
    uint64_t quadrant;
    memcpy(&quadrant, &rounded, sizeof quadrant);
    const double multiple = rounded - round;
    const double first = x - multiple * 0x1.921fb54400000p+0;
    const double product = multiple * 0x1.0b4611a600000p-34;
    const double second = first - product;
    const double lost = (first - second) - product;
    const double correction = lost - multiple * 0x1.3198a2e037073p-69;
    const double y = second + correction;
    const double tail = (second - y) + correction;
    const double z = y * y;
    const double cube = z * y;
    const double p = 0x1.111111110f8a6p-7 + z * (-0x1.a01a019c161d5p-13 + z * (0x1.71de357b1fe7dp-19
        + z * (-0x1.ae5e68a2b9cebp-26 + z * 0x1.5d93a5acfd57cp-33)));
    const double s = y - ((z * (0.5 * tail - cube * p) - tail) - cube * -0x1.5555555555549p-3);
    const double r = z * (0x1.555555555554cp-5 + z * (-0x1.6c16c16c15177p-10 + z * (0x1.a01a019cb1590p-16
        + z * (-0x1.27e4f809c52adp-22 + z * (0x1.1ee9ebdb4b1c4p-29 + z * -0x1.8fae9be8838d4p-37)))));
    const double half = 0.5 * z;
    const double leading = 1.0 - half;
    const double c = leading + (((1.0 - leading) - half) + (z * r - y * tail));
    const double a = quadrant & 1 ? c : s;
    const double b = quadrant & 1 ? s : c;
    *sine = quadrant & 2 ? -a : a;
    *cosine = (quadrant + 1) & 2 ? -b : b;
}

static inline double sine(double x)
{
    double s, c;
    sine_cosine(x, &s, &c);
    return s;
}

static inline double cosine(double x)
{
    double s, c;
    sine_cosine(x, &s, &c);
    return c;
}

static inline double signum(double x) { return x > 0.0 ? 1.0 : x < 0.0 ? -1.0 : x; }
static inline double smaller(double a, double b) { return a < b || isnan(a) ? a : b; }
static inline double larger(double a, double b) { return a > b || isnan(a) ? a : b; }
