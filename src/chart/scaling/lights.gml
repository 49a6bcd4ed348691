% Spheres on a floor below n lights in a circle, which together are as bright as one.
{ /b /g /r { /v /u /face r g b point 0.8 0.1 20.0 } } /paint
0.9 0.3 0.2 paint apply sphere -1.1 0.0 0.0 translate
0.2 0.4 0.9 paint apply sphere  1.1 0.0 0.0 translate union
0.9 0.8 0.3 paint apply sphere  0.0 0.0 -1.8 translate union
0.6 0.6 0.6 paint apply plane 0.0 -1.0 0.0 translate union
-25.0 rotatex 0.0 0.0 5.0 translate /scene

1.0 n real divf /share
{ /i
  i real 360.0 mulf n real divf /angle
  angle cos 3.0 mulf  4.0  angle sin 3.0 mulf 3.0 addf  point
  share share share point
  pointlight
} /lamp
{ /self /i i n eqi { } { i lamp apply  i 1 addi self self apply } if } /hang

0.2 0.2 0.2 point
[ 0 hang hang apply ]
scene 0 70.0 160 120 "lights.ppm" render
