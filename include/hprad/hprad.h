#ifndef HPRAD_HPRAD_H
#define HPRAD_HPRAD_H

/* Everything: a scene is read, solved, probed, rendered and written. */
#include <hprad/context.h>
#include <hprad/render.h>
#include <hprad/scene.h>
#include <hprad/solve.h>
#include <hprad/status.h>
#include <hprad/version.h>

#endif
