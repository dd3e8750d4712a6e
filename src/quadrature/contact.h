/*
 * Where two elements touch, and how their front parts fall into pieces of which each pair shares an edge, a
 * vertex, or nothing. Two polygons in different planes can only meet on the line where their planes cross,
 * and each, cut to the front of the other's plane, meets that line in an edge, a vertex or not at all; so
 * this covers shared edges and vertices, T-junctions, partial edges and penetration alike.
 */
#ifndef HPR_QUADRATURE_CONTACT_H
#define HPR_QUADRATURE_CONTACT_H

#include "quadrature/pair.h"

#include <stdbool.h>

typedef enum hpr_contact_kind {
    HPR_CONTACT_HIDDEN,   /* nothing of one is in front of the other */
    HPR_CONTACT_SEPARATE, /* they do not touch */
    HPR_CONTACT_VERTEX,   /* they share a point */
    HPR_CONTACT_EDGE      /* they share a segment */
} hpr_contact_kind;

/* How a piece touches the other element. */
typedef enum hpr_touch {
    HPR_TOUCH_NONE,
    HPR_TOUCH_FIRST,  /* at the first contact point, its vertex 0 */
    HPR_TOUCH_SECOND, /* at the second contact point, its vertex 0 */
    HPR_TOUCH_EDGE    /* along the contact: vertex 0 is the first point, vertex 1 the second */
} hpr_touch;

typedef struct hpr_piece {
    hpr_cell cell;
    hpr_touch touch;
} hpr_piece;

enum { HPR_PIECES_MAX = HPR_POLYGON_MAX + 2 };

typedef struct hpr_contact {
    hpr_contact_kind kind;
    double length_m;                           /* of a shared segment */
    hpr_polygon recv_front, send_front;        /* the parts in front of the other's plane */
    int point_count;                           /* 1: the shared point, 2: the ends of the shared segment */
    double recv_point[2][2], send_point[2][2]; /* in the parameters of both */
    int recv_count, send_count;
    hpr_piece recv[HPR_PIECES_MAX], send[HPR_PIECES_MAX];
} hpr_contact;

/* Pieces of the two cells that cover exactly their mutually visible fronts. Points nearer than `contact_m`
 * count as touching. */
void hpr_contact_find(const hpr_pair *pair, const hpr_cell *recv, const hpr_cell *send, double contact_m,
                      hpr_contact *contact);

#endif
