#include "quadrature/contact.h"

/* One side of the pair while its contact is worked out. */
typedef struct side {
    const hpr_element_frame *frame;
    const hpr_cell *cell;
    hpr_affine height; /* over the other's plane */
    hpr_polygon front; /* its part in front of the other's plane; corners on the line come first */
    bool whole;        /* nothing was cut off */
    int on_line;       /* how many corners (0, 1, 2) lie on the line */
    double along[2];   /* their positions along the line */
} side;

static void append(hpr_polygon *polygon, double s, double t)
{
    if (polygon->count < HPR_POLYGON_MAX) {
        polygon->corner[polygon->count][0] = s;
        polygon->corner[polygon->count][1] = t;
        polygon->count++;
    }
}

static double height_at(const side *side, const double corner[2], double contact_m)
{
    double h = hpr_affine_at(&side->height, corner[0], corner[1]);
    return fabs(h) <= contact_m ? 0 : h;
}

/* Sutherland & Hodgman 1974 against height >= 0. */
static void cut_to_front(side *side, double contact_m)
{
    const hpr_cell *cell = side->cell;
    const double *o = cell->origin, *e1 = cell->edge1, *e2 = cell->edge2;
    hpr_polygon whole = {0};
    append(&whole, o[0], o[1]);
    append(&whole, o[0] + e1[0], o[1] + e1[1]);
    if (cell->shape == HPR_SHAPE_PARALLELOGRAM)
        append(&whole, o[0] + e1[0] + e2[0], o[1] + e1[1] + e2[1]);
    else if (cell->shape == HPR_SHAPE_QUADRILATERAL)
        append(&whole, cell->opposite[0], cell->opposite[1]);
    append(&whole, o[0] + e2[0], o[1] + e2[1]);
    side->front.count = 0;
    side->whole = true;
    for (int i = 0; i < whole.count; i++) {
        const double *p = whole.corner[i], *q = whole.corner[(i + 1) % whole.count];
        double hp = height_at(side, p, contact_m), hq = height_at(side, q, contact_m);
        if (hp >= 0)
            append(&side->front, p[0], p[1]);
        else
            side->whole = false;
        if (hp * hq < 0) {
            double f = hp / (hp - hq);
            append(&side->front, p[0] + f * (q[0] - p[0]), p[1] + f * (q[1] - p[1]));
        }
    }
}

/* Turns the polygon so that the corners on the line come first, in order; counts them. */
static void turn_to_line(side *side, double contact_m)
{
    hpr_polygon turned = side->front;
    int n = turned.count, first = 0;
    bool on[HPR_POLYGON_MAX];
    side->on_line = 0;
    for (int i = 0; i < n; i++) {
        on[i] = fabs(hpr_affine_at(&side->height, turned.corner[i][0], turned.corner[i][1])) <= contact_m;
        side->on_line += on[i] && side->on_line < 2;
    }
    if (side->on_line == 0)
        return;
    while (!on[first] || on[(first + n - 1) % n])
        first++;
    for (int i = 0; i < n; i++) {
        side->front.corner[i][0] = turned.corner[(first + i) % n][0];
        side->front.corner[i][1] = turned.corner[(first + i) % n][1];
    }
}

/* True if something of the side lies strictly in front of the other's plane. */
static bool has_front(const side *side, double contact_m)
{
    for (int i = 0; i < side->front.count; i++) {
        if (hpr_affine_at(&side->height, side->front.corner[i][0], side->front.corner[i][1]) > contact_m)
            return side->front.count >= 3;
    }
    return false;
}

static void place_on_line(side *side, hpr_vec3 direction)
{
    for (int i = 0; i < side->on_line && i < 2; i++) {
        hpr_vec3 p = hpr_frame_point(side->frame, side->front.corner[i][0], side->front.corner[i][1]);
        side->along[i] = hpr_dot(direction, p);
    }
    if (side->on_line == 1)
        side->along[1] = side->along[0];
}

/* Parameters of the point at `along` on the side's edge on the line; an end point within contact_m is taken.
 */
static void line_point(const side *side, double along, double contact_m, double point[2])
{
    const double *p = side->front.corner[0], *q = side->front.corner[side->on_line - 1];
    double length = side->along[1] - side->along[0];
    double f = side->on_line < 2 || fabs(along - side->along[0]) <= contact_m ? 0
               : fabs(along - side->along[1]) <= contact_m                    ? 1
                                                           : (along - side->along[0]) / length;
    for (int a = 0; a < 2; a++)
        point[a] = f == 1 ? q[a] : p[a] + f * (q[a] - p[a]);
}

static void add_piece(hpr_piece *pieces, int *count, hpr_touch touch, const double p0[2], const double p1[2],
                      const double p2[2])
{
    hpr_cell cell = hpr_cell_triangle(p0, p1, p2);
    double area = fabs(cell.edge1[0] * cell.edge2[1] - cell.edge1[1] * cell.edge2[0]);
    double size = fabs(cell.edge1[0]) + fabs(cell.edge1[1]) + fabs(cell.edge2[0]) + fabs(cell.edge2[1]);
    if (area > 1e-15 * size * size && *count < HPR_PIECES_MAX)
        pieces[(*count)++] = (hpr_piece){cell, touch};
}

/* Triangles from corner 0 of a convex chain to each of its edges. */
static void add_fan(hpr_piece *pieces, int *count, hpr_touch touch, const hpr_polygon *chain)
{
    for (int i = 1; i + 1 < chain->count; i++)
        add_piece(pieces, count, touch, chain->corner[0], chain->corner[i], chain->corner[i + 1]);
}

/* Pieces around a single contact point. */
static void split_at_vertex(const side *side, double at, double contact_m, hpr_piece *pieces, int *count)
{
    double point[2];
    hpr_polygon chain = {0};
    line_point(side, at, contact_m, point);
    append(&chain, point[0], point[1]);
    int n = side->front.count;
    for (int i = side->on_line == 2 ? 1 : side->on_line; i < n; i++)
        append(&chain, side->front.corner[i][0], side->front.corner[i][1]);
    if (side->on_line == 2)
        append(&chain, side->front.corner[0][0], side->front.corner[0][1]);
    add_fan(pieces, count, HPR_TOUCH_FIRST, &chain);
}

/* The corner off the line that makes the edge's triangle: the highest; among equals the one that leaves the
 * rest at the first contact point, so that the rests of both sides touch there. */
static int choose_apex(const side *side, bool rising)
{
    int n = side->front.count, best = rising ? 2 : n - 1;
    double highest = hpr_affine_at(&side->height, side->front.corner[best][0], side->front.corner[best][1]);
    for (int i = 2; i < n; i++) {
        double h = hpr_affine_at(&side->height, side->front.corner[i][0], side->front.corner[i][1]);
        if (h > highest * (1 + 1e-6)) {
            highest = h;
            best = i;
        }
    }
    return best;
}

/* Pieces along the contact [low, high]: one triangle on it, one fan at each end. */
static void split_at_edge(const side *side, double low, double high, double contact_m, hpr_piece *pieces,
                          int *count)
{
    bool rising = side->along[1] > side->along[0];
    int n = side->front.count, apex = choose_apex(side, rising);
    double p[2], q[2]; /* in the order of the polygon */
    line_point(side, rising ? low : high, contact_m, p);
    line_point(side, rising ? high : low, contact_m, q);
    const double *top = side->front.corner[apex];
    add_piece(pieces, count, HPR_TOUCH_EDGE, rising ? p : q, rising ? q : p, top);
    hpr_polygon before = {0}, after = {0};
    append(&after, q[0], q[1]);
    for (int i = 1; i <= apex; i++)
        append(&after, side->front.corner[i][0], side->front.corner[i][1]);
    append(&before, p[0], p[1]);
    for (int i = apex; i < n; i++)
        append(&before, side->front.corner[i][0], side->front.corner[i][1]);
    append(&before, side->front.corner[0][0], side->front.corner[0][1]);
    add_fan(pieces, count, rising ? HPR_TOUCH_SECOND : HPR_TOUCH_FIRST, &after);
    add_fan(pieces, count, rising ? HPR_TOUCH_FIRST : HPR_TOUCH_SECOND, &before);
}

/* The contact point at `along`, in the parameters of both. */
static void add_contact(const side *a, const side *b, double along, double contact_m, hpr_contact *contact)
{
    int k = contact->point_count++;
    line_point(a, along, contact_m, contact->recv_point[k]);
    line_point(b, along, contact_m, contact->send_point[k]);
}

static void leave_whole(const side *side, hpr_piece *pieces, int *count)
{
    if (side->whole && side->cell->shape != HPR_SHAPE_QUADRILATERAL)
        pieces[(*count)++] = (hpr_piece){*side->cell, HPR_TOUCH_NONE};
    else
        add_fan(pieces, count, HPR_TOUCH_NONE, &side->front);
}

void hpr_contact_find(const hpr_pair *pair, const hpr_cell *recv, const hpr_cell *send, double contact_m,
                      hpr_contact *contact)
{
    side a = {.frame = &pair->recv, .cell = recv, .height = pair->recv_height};
    side b = {.frame = &pair->send, .cell = send, .height = pair->send_height};
    *contact = (hpr_contact){.kind = HPR_CONTACT_HIDDEN};
    cut_to_front(&a, contact_m);
    cut_to_front(&b, contact_m);
    if (!has_front(&a, contact_m) || !has_front(&b, contact_m))
        return;
    contact->kind = HPR_CONTACT_SEPARATE;
    contact->recv_front = a.front;
    contact->send_front = b.front;
    turn_to_line(&a, contact_m);
    turn_to_line(&b, contact_m);
    if (a.on_line && b.on_line) {
        hpr_vec3 direction = hpr_cross(pair->recv.normal, pair->send.normal);
        direction = hpr_scale(direction, 1 / hpr_length(direction));
        place_on_line(&a, direction);
        place_on_line(&b, direction);
        double low = fmax(fmin(a.along[0], a.along[1]), fmin(b.along[0], b.along[1]));
        double high = fmin(fmax(a.along[0], a.along[1]), fmax(b.along[0], b.along[1]));
        if (high - low > contact_m) {
            contact->kind = HPR_CONTACT_EDGE;
            add_contact(&a, &b, low, contact_m, contact);
            add_contact(&a, &b, high, contact_m, contact);
            contact->length_m = high - low;
            split_at_edge(&a, low, high, contact_m, contact->recv, &contact->recv_count);
            split_at_edge(&b, low, high, contact_m, contact->send, &contact->send_count);
            return;
        }
        if (high - low >= -contact_m) {
            contact->kind = HPR_CONTACT_VERTEX;
            add_contact(&a, &b, (low + high) / 2, contact_m, contact);
            split_at_vertex(&a, (low + high) / 2, contact_m, contact->recv, &contact->recv_count);
            split_at_vertex(&b, (low + high) / 2, contact_m, contact->send, &contact->send_count);
            return;
        }
    }
    leave_whole(&a, contact->recv, &contact->recv_count);
    leave_whole(&b, contact->send, &contact->send_count);
}
