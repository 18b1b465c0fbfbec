/* render SCENE: one frame of each sensor at the start of the recorded path. */
#include <simuli/simuli.h>
#include <stdio.h>
#include <stdlib.h>

static int fail(const char* what) {
  fprintf(stderr, "%s: %s\n", what, simuli_error());
  return 1;
}

static int render(simuli_scene* scene, const simuli_sensor* sensor, const simuli_shot* shot) {
  const size_t rays = sensor->rows * sensor->columns;
  float* values = malloc(rays * 3 * sizeof(float));
  double sum = 0.0;
  simuli_status status;
  if (sensor->is_camera) {
    status = simuli_render_camera(scene, sensor->name, shot, values, 3 * rays);
  } else {
    const simuli_lidar_frame frame = {values, NULL, NULL, NULL, rays};
    status = simuli_render_lidar(scene, sensor->name, shot, &frame);
  }
  for (size_t i = 0; status == SIMULI_OK && i < rays; ++i) sum += values[sensor->is_camera ? 3 * i : i];
  free(values);
  if (status != SIMULI_OK) return fail(sensor->name);
  printf("%s: mean %s %.3f\n", sensor->name, sensor->is_camera ? "red" : "range", sum / (double)rays);
  return 0;
}

int main(int argc, char** argv) {
  simuli_device* device = NULL;
  simuli_scene* scene = NULL;
  double start_s = 0.0, end_s = 0.0;
  int failed = 0;
  if (argc != 2) return fprintf(stderr, "usage: render SCENE\n"), 2;
  if (simuli_device_open(NULL, &device) != SIMULI_OK) return fail("device");
  printf("simuli %s on %s\n", simuli_version(), simuli_device_name(device));
  if (simuli_scene_open(device, argv[1], &scene) != SIMULI_OK) return fail("scene");
  if (simuli_scene_span(scene, &start_s, &end_s) != SIMULI_OK) return fail("span");
  for (size_t i = 0; i < simuli_scene_sensor_count(scene); ++i) {
    simuli_sensor sensor;
    simuli_shot shot;
    if (simuli_scene_sensor(scene, i, &sensor) != SIMULI_OK) return fail("sensor");
    const double stop_s = sensor.is_camera ? start_s : start_s + 0.1;
    if (simuli_scene_shot(scene, sensor.name, start_s, stop_s, &shot) != SIMULI_OK) return fail("shot");
    failed |= render(scene, &sensor, &shot);
  }
  simuli_scene_close(scene);
  simuli_device_close(device);
  return failed;
}
