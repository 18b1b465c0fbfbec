#ifndef SIMULI_H
#define SIMULI_H
/* The main calls for C and for languages that bind to C. No exception crosses: a call that can fail returns a
 * simuli_status, and simuli_error() tells what went wrong. Handles are opaque; close functions take NULL too.
 * A device, and what was opened on it, are used by one thread at a time. Metres, seconds, radians;
 * right-handed frames: world z up; LiDARs x forward, y left, z up; cameras x right, y down, z forward. */
#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

typedef enum simuli_status { /* also the exit codes of the program */
                             SIMULI_OK = 0,
                             SIMULI_USAGE = 2,  /* an argument that is not allowed */
                             SIMULI_INPUT = 3,  /* a file that is missing or not as it should be */
                             SIMULI_DEVICE = 4, /* no such OpenCL device, or it failed */
                             SIMULI_KERNEL = 5,
                             SIMULI_NUMERIC = 6,
                             SIMULI_NOTHING = 8, /* of an import nothing is left */
                             SIMULI_INTERNAL = 70,
                             SIMULI_MEMORY = 71 /* of the host; a device's is SIMULI_DEVICE */
} simuli_status;

typedef struct simuli_device simuli_device;
typedef struct simuli_scene simuli_scene;
typedef struct simuli_frame simuli_frame;

/* How something is done: a bundle ("draft", "balanced", "exact", "reference"; NULL: balanced) and "key=value"
 * settings, as `simuli train --set help` lists them. Wherever options may be NULL, that is balanced. */
typedef struct simuli_options {
  const char* quality;
  const char* const* settings;
  size_t setting_count;
} simuli_options;

/* p_a = rotate(rotation_wxyz, p_b) + position_m; any quaternion but zero. */
typedef struct simuli_pose {
  double position_m[3];
  double rotation_wxyz[4];
} simuli_pose;

/* Where a sensor is, and when, while it takes one frame. */
typedef struct simuli_shot {
  simuli_pose world_from_sensor_start;
  simuli_pose world_from_sensor_end;
  double time_start_s; /* of the scene's log */
  double time_end_s;   /* equal to the start: an instant (cameras with a global shutter) */
} simuli_shot;

/* "0.1.0" */
const char* simuli_version(void);
/* What the last failed call of this thread said, one line; "" when none has failed. */
const char* simuli_error(void);

/* request: part of "platform / device", or its index; NULL or "": the first usable one. A context and queue of the
 * caller's: simuli_device_adopt() of <simuli/opencl.h>. */
simuli_status simuli_device_open(const char* request, simuli_device** device);
const char* simuli_device_name(const simuli_device* device);
void simuli_device_close(simuli_device* device);

/* ---- Training and evaluation ---- */

/* Called after each iteration; what is not 0 ends the training with SIMULI_USAGE. */
typedef int (*simuli_progress)(int iteration, double psnr_db, void* user);

typedef struct simuli_training {
  int iterations;
  double psnr_db;    /* of the last 20 pictures or so that it was trained on */
  double distance_m; /* mean error of the last sweeps */
  size_t camera_particles;
  size_t lidar_particles;
  double seconds;
} simuli_training;

/* What `simuli train LOG -o SCENE` does, bit for bit. progress and result may be NULL. SIMULI_INPUT, before
 * anything is read, when there is something at `scene`: nothing is replaced. */
simuli_status simuli_train(const simuli_device* device,
                           const char* log,
                           const char* scene,
                           const simuli_options* options,
                           simuli_progress progress,
                           void* user,
                           simuli_training* result);

/* Means over the frames compared; NaN where there is none. */
typedef struct simuli_evaluation {
  size_t images;
  size_t sweeps;
  int is_held_out; /* training read none of them */
  double psnr_db;
  double ssim;
  double distance_median_m;
  double intensity_rmse;
  double raydrop_accuracy;
  double chamfer_m;
  double raydrop_trivial; /* the accuracy of "every ray returns" */
  double drop_recall;     /* of the dropped rays those found; NaN: none dropped */
  double drop_precision;  /* of the rays said to drop those that do; NaN: none is said to */
} simuli_evaluation;

/* What `simuli eval SCENE LOG` does; the settings may name image_scale, held_out_every, held_out_middle and
 * held_out_last, too: held_out_every=5 alone compares the frames between those trained on, held_out_last=0.2 alone
 * the end of the path, held_out_middle=0.2 alone a chunk in its middle. */
simuli_status simuli_evaluate(const simuli_device* device,
                              const char* scene,
                              const char* log,
                              const simuli_options* options,
                              simuli_evaluation* result);

/* ---- Scenes and their sensors ---- */

/* Reads a scene folder or a file of splats. The scene keeps its device: that may be closed at once. */
simuli_status simuli_scene_open(const simuli_device* device, const char* folder, simuli_scene** scene);
/* Writes it with all edits; the sensors of its log stay as they were. */
simuli_status simuli_scene_save(const simuli_scene* scene, const char* folder);
void simuli_scene_close(simuli_scene* scene);
/* Of a file of splats: how many particles with NaN, Inf or a zero quaternion are left out. */
size_t simuli_scene_left_out(const simuli_scene* scene);
/* Of a file of splats, a line each: what is left out, and how it says that it was trained. "" of others; it lives
   as long as the scene. */
const char* simuli_scene_notes(const simuli_scene* scene);
/* How frames are rendered from now on. */
simuli_status simuli_scene_set_options(simuli_scene* scene, const simuli_options* options);

typedef struct simuli_sensor {
  const char* name; /* lives as long as the scene */
  int is_camera;    /* 0: a LiDAR */
  size_t columns;   /* pixels, or rays of a beam */
  size_t rows;      /* pixels, or beams */
  simuli_pose rig_from_sensor;
  double duration_s; /* of a frame */
} simuli_sensor;

/* The sensors that the scene was trained on, and those added: index 0 to count - 1. */
size_t simuli_scene_sensor_count(const simuli_scene* scene);
simuli_status simuli_scene_sensor(const simuli_scene* scene, size_t index, simuli_sensor* sensor);
/* Mounts a built-in camera or LiDAR ("hesai_pandar128", "hesai_xt32@20") or the one of a sensor file as one more
 * sensor of the scene. as: what it is called; NULL: as it is. */
simuli_status simuli_scene_add_sensor(simuli_scene* scene,
                                      const char* name_or_file,
                                      const char* as,
                                      const simuli_pose* rig_from_sensor);

typedef struct simuli_camera {
  const char* name;
  const char* lens;              /* "pinhole", "opencv_fisheye", ...; NULL: pinhole */
  const double* lens_parameters; /* of that lens, in the order of its names in files */
  size_t lens_parameter_count;
  int width, height;     /* pixels */
  double fx, fy, cx, cy; /* pixels; the centre of the first pixel is (0.5, 0.5) */
  const char* shutter;   /* "global", "top_to_bottom", ...; NULL: global */
  double duration_s;     /* of a rolling shutter's read-out */
} simuli_camera;
simuli_status simuli_scene_add_camera(simuli_scene* scene,
                                      const simuli_camera* camera,
                                      const simuli_pose* rig_from_camera);

typedef struct simuli_lidar_row {
  double elevation;         /* rad */
  double azimuth_offset;    /* rad */
  double vertical_offset;   /* m */
  double horizontal_offset; /* m */
  double radial_offset;     /* m */
  double time_offset;       /* s */
} simuli_lidar_row;
typedef struct simuli_lidar {
  const char* name;
  const simuli_lidar_row* rows; /* top to bottom */
  size_t row_count;
  int columns;
  double azimuth_first; /* rad, of column 0 */
  double azimuth_span;  /* rad, of all columns */
  int is_clockwise;
  double sweep_s;
  double range_min, range_max; /* m */
  double beam_divergence;      /* rad, full angle; 0: ideal rays */
} simuli_lidar;
simuli_status simuli_scene_add_lidar(simuli_scene* scene,
                                     const simuli_lidar* lidar,
                                     const simuli_pose* rig_from_lidar);

/* First and last time of the recorded path. */
simuli_status simuli_scene_span(const simuli_scene* scene, double* start_s, double* end_s);
/* Where sensor `name` is on the recorded path from time_start_s to time_end_s. */
simuli_status simuli_scene_shot(
    const simuli_scene* scene, const char* name, double time_start_s, double time_end_s, simuli_shot* shot);

/* ---- Actors ---- */

typedef struct simuli_actor {
  const char* name; /* these two live until the scene is edited */
  const char* kind;
  double size_m[3]; /* length, width, height */
  size_t pose_count;
} simuli_actor;
size_t simuli_scene_actor_count(const simuli_scene* scene);
simuli_status simuli_scene_actor(const simuli_scene* scene, size_t index, simuli_actor* actor);
/* Its track: `count` is the length of both arrays, the actor's pose_count. */
simuli_status simuli_scene_actor_track(
    const simuli_scene* scene, size_t index, double* times_s, simuli_pose* world_from_actor, size_t count);

typedef enum simuli_edit_kind {
  SIMULI_REMOVE = 0,
  SIMULI_MOVE = 1,    /* by_m, throughout its track, in its own frame: forward, left, up */
  SIMULI_RETIME = 2,  /* rate times as fast, delay_s later */
  SIMULI_RETRACK = 3, /* the track times_s, world_from_actor, pose_count instead of its own */
  SIMULI_DUPLICATE = 4, /* a second one, called new_name; not of a single frame */
  SIMULI_TURN = 5       /* by yaw_rad to its left, throughout its track, about its own up */
} simuli_edit_kind;
typedef struct simuli_edit {
  simuli_edit_kind kind;
  const char* actor;
  double by_m[3];
  double rate;
  double delay_s;
  const double* times_s;
  const simuli_pose* world_from_actor;
  size_t pose_count;
  const char* new_name;
  double yaw_rad;
} simuli_edit;
/* For all frames from now on. */
simuli_status simuli_scene_edit(simuli_scene* scene, const simuli_edit* edit);
/* Adds an actor of another scene, with its particles and its track. */
simuli_status simuli_scene_add_actor(simuli_scene* scene,
                                     const simuli_scene* other,
                                     const char* actor,
                                     const char* new_name);

/* ---- Frames ---- */

/* What a frame is asked for beside sensor and shot. All zeros: nothing. */
typedef struct simuli_request {
  const simuli_edit* edits; /* of this frame alone, one after the other */
  size_t edit_count;
  const unsigned char* rays; /* [rows][columns]; those that are not 0 are rendered, the others see the background: a
                                LiDAR's return nothing. NULL: all */
  size_t ray_count;          /* of `rays` */
  int is_ungraded;           /* pictures not through the scene's colour grids: those have gradients */
  int with_actors;           /* for SIMULI_ACTORS, labels and flow; costs a second rendering */
} simuli_request;

/* Queues a frame and returns; any number may be on their way at once. request may be NULL. */
simuli_status simuli_render(simuli_scene* scene,
                            const char* name,
                            const simuli_shot* shot,
                            const simuli_request* request,
                            simuli_frame** frame);
void simuli_frame_close(simuli_frame* frame);
simuli_status simuli_frame_is_ready(const simuli_frame* frame, int* is_ready);
simuli_status simuli_frame_wait(const simuli_frame* frame);
/* Starts bringing its results to the host. */
simuli_status simuli_frame_fetch(const simuli_frame* frame);

typedef enum simuli_quantity {
  SIMULI_RGB = 0,           /* of cameras, 3 values per pixel in [0, 1] */
  SIMULI_FEATURE = 1,       /* 3 values per ray, as blended: colour, or intensity, hit logit, drop logit */
  SIMULI_OPACITY = 2,       /* 1 value per ray from here on: 1 - transmittance */
  SIMULI_DISTANCE = 3,      /* m, mean of where the ray's light comes from; 0: nothing was met */
  SIMULI_MEDIAN = 4,        /* m, where half of it is gone; 0: nowhere */
  SIMULI_RANGE = 5,         /* of LiDARs, m from the ray's own origin; 0: no return */
  SIMULI_INTENSITY = 6,     /* of LiDARs, [0, 1] */
  SIMULI_DROP = 7,          /* of LiDARs: probability that the ray does not return */
  SIMULI_TRANSMITTANCE = 8, /* these two are what gradients are taken of */
  SIMULI_DISTANCE_SUM = 9,  /* sum of w tau, m */
  SIMULI_ACTORS = 10        /* 1 + index of the actor whose body is there; 0: none */
} simuli_quantity;
/* [rows][columns], or [rows][columns][3]; count is the length of `values`: SIMULI_USAGE when that is another one.
 * Waits. */
simuli_status simuli_frame_values(const simuli_frame* frame,
                                  simuli_quantity quantity,
                                  float* values,
                                  size_t count);
/* [rays][3] in the world, m, of a LiDAR; of rays without a return their origins. */
simuli_status simuli_frame_points(const simuli_frame* frame, double* xyz, size_t count);

/* [rows][columns]: how well what a frame of the scene shows is known, from 0 (no recorded frame saw it) to 1: the share
 * of pixels alike that are within 0.05 of the truth, of LiDAR rays alike that return within 2 cm of it or rightly don't.
 * SIMULI_USAGE when the scene keeps nothing to tell it from: trained before there was support, or not at all. Waits. */
simuli_status simuli_frame_support(simuli_scene* scene, const simuli_frame* frame, float* values, size_t count);

/* What is true of an actor that is there during a frame: docs/RENDERS.md, "Labels". */
typedef struct simuli_label {
  size_t actor;     /* its index */
  double time_s;    /* when the sensor looked at the middle of its box: poses are of then */
  double size_m[3]; /* length, width, height */
  simuli_pose world_from_actor, rig_from_actor, sensor_from_actor;
  size_t rays;            /* pixels, or returns, of its body */
  double occlusion;       /* NaN: it would have no ray even if it were alone */
  double truncation;      /* these are of cameras */
  double projected_px[4]; /* left, top, right, bottom around the box within the picture; NaN: not in it */
  double visible_px[4];   /* around the body's pixels; NaN: there are none */
} simuli_label;
/* Of a frame of the scene that was asked for with_actors. room: of `labels`, at least simuli_scene_actor_count();
 * count: how many are there. Waits. */
simuli_status simuli_frame_labels(
    simuli_scene* scene, const simuli_frame* frame, simuli_label* labels, size_t room, size_t* count);
/* [rows][columns][3] each, either may be NULL: px to the right and down to where the camera sees the same point in the
 * frame `to`, and 1 (zeros: nowhere); m by which the point moves in the camera's axes. Of a camera's frame of the scene
 * that was asked for with_actors. Waits. */
simuli_status simuli_frame_flow(const simuli_scene* scene,
                                const simuli_frame* frame,
                                const simuli_frame* to,
                                float* pixels,
                                float* points,
                                size_t count);

/* ---- Particles and gradients ---- */

/* values[columns][rows], a column per parameter: mean, log scale, rotation w x y z, opacity logit, SH coefficients.
 * `values` may be NULL: then only rows and columns are told. */
simuli_status simuli_scene_particles(
    const simuli_scene* scene, int is_lidar, size_t* rows, size_t* columns, float* values, size_t count);
/* Other numbers for the same parameters; as many particles as there are, if some are of actors. */
simuli_status simuli_scene_set_particles(
    simuli_scene* scene, int is_lidar, size_t rows, const float* values, size_t count);
/* dL/d(particles) of the set that the frame's sensor sees, as simuli_scene_particles() has them, from the derivatives
 * of a loss L by FEATURE, TRANSMITTANCE and DISTANCE_SUM of each ray (NULL: 0). Pictures through colour grids have
 * none. */
simuli_status simuli_frame_gradients(simuli_scene* scene,
                                     const simuli_frame* frame,
                                     const float* feature,
                                     const float* transmittance,
                                     const float* distance_sum,
                                     float* values,
                                     size_t count);

#ifdef __cplusplus
}
#endif
#endif
