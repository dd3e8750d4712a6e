/* What arrives at a point from an element. */
#ifndef HPR_QUADRATURE_POINT_H
#define HPR_QUADRATURE_POINT_H

#include "quadrature/block.h"

/* Working memory of one thread. */
typedef struct hpr_point_scratch hpr_point_scratch;

hpr_status hpr_point_scratch_create(hpr_context *ctx, hpr_point_scratch **scratch);
void hpr_point_scratch_destroy(hpr_point_scratch **scratch);

/*
 * row[l] = ∫_s G(x,y) V(x,y) T_l(y) dA_y, 1/m, x the point (s,t) of task->recv; row [n_send]. The inner
 * integrals of hpr_block's nested and clipped rules: as exact as task->tolerance, relative; by rays past
 * more than HPR_CLIP_BLOCKERS blockers. Of the task, the receiver's degree and parts, negligible, contact_m
 * and clip do not matter. Adds to the counts. Concurrent calls allowed with distinct row, scratch and result.
 */
void hpr_point_gather(const hpr_block_task *task, double s, double t, double *row, hpr_point_scratch *scratch,
                      hpr_block_result *result);

#endif
