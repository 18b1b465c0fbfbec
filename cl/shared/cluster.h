// cluster.h - clusters: consecutive particles that frames keep or leave out together (METHOD section 4).
#ifndef SIMULI_CL_SHARED_CLUSTER_H
#define SIMULI_CL_SHARED_CLUSTER_H

// Particles of a cluster; a multiple of all lane counts, so that no vector lies in two.
#define SIM_CLUSTER 256

// Rows of bounds, one real per cluster each. The ball holds all means, in the axes that they are given in.
#define SIM_C_CENTRE 0
#define SIM_C_RADIUS 3
#define SIM_C_LOG_SCALE 4  // the largest
#define SIM_C_OPACITY 5    // the largest logit
#define SIM_C_FROM 6       // the least and the largest of their levels of detail (SIM_DETAIL_.. of layout.h)
#define SIM_C_UNTIL 7
#define SIM_CLUSTER_ROWS 8

#endif
