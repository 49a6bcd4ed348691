% A plate with n holes in rows: the smaller the more there are, so that they always take the same share
% of it.
{ /v /u /face 0.3 0.5 0.8 point 0.8 0.0 1.0 } cube 4.0 0.3 4.0 scale -2.0 -0.15 -2.0 translate /plate

% The least number of columns whose square is n or more, and their distance.
n real sqrt floor /columns
columns columns muli n lessi { columns 1 addi } { columns } if /columns
4.0 columns real divf /step

{ /v /u /face 0.8 0.7 0.3 point 0.8 0.0 1.0 } cylinder
0.35 step mulf 1.0 0.35 step mulf scale  0.0 -0.5 0.0 translate /hole
{ /i i real 0.5 addf step mulf 2.0 subf } /place
{ /self /i /rest
  i n eqi { rest } {
    rest
    hole  i columns modi place apply  0.0  i columns divi place apply  translate
    difference
    i 1 addi self self apply
  } if
} /drill
plate 0 drill drill apply  -50.0 rotatex 20.0 rotatey  0.0 0.3 5.0 translate /drilled

0.3 0.3 0.3 point
[ 0.6 -1.0 1.0 point 0.8 0.8 0.8 point light ]
drilled 0 60.0 320 240 "holes.ppm" render
