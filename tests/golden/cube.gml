% The faces of a cube, each in a colour of its own, shaded by u and v.
[ 1.0 0.0 0.0 point 0.0 1.0 0.0 point 0.0 0.0 1.0 point 1.0 1.0 0.0 point 0.0 1.0 1.0 point 1.0 0.0 1.0 point ] /colors
{ /v /u /face colors face get /c
  c getx u mulf c gety v mulf c getz point 1.0 0.0 1.0
} cube -0.5 -0.5 -0.5 translate 35.0 rotatey 30.0 rotatex 0.0 0.0 1.0 translate /scene
1.0 1.0 1.0 point [] scene 0 60.0 64 48 "cube.ppm" render
