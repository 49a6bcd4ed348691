% Two images of one program: the second sees what the first saw, smaller.
{ /v /u /face 0.9 0.6 0.2 point 0.8 0.2 9.0 } sphere 0.0 0.0 1.5 translate /ball
1.0 -1.0 1.0 point 0.9 0.9 0.9 point light /sun
{ /name /fov 0.2 0.2 0.2 point [ sun ] ball 1 fov 64 48 name render } /shoot
60.0 "near.ppm" shoot apply
100.0 "far.ppm" shoot apply
