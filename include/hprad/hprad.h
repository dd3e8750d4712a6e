/** All of hprad. */
#ifndef HPRAD_HPRAD_H
#define HPRAD_HPRAD_H

#include <hprad/baseline.h>
#include <hprad/batch.h>
#include <hprad/compare.h>
#include <hprad/context.h>
#include <hprad/job.h>
#include <hprad/plan.h>
#include <hprad/reference.h>
#include <hprad/render.h>
#include <hprad/report.h>
#include <hprad/scene.h>
#include <hprad/solve.h>
#include <hprad/status.h>
#include <hprad/study.h>
#include <hprad/version.h>

#endif
