% A cone and its mirror image: negative scale.
{ /v /u /face face 0 eqi { u v 0.3 point } { 1.0 u v point } if 0.8 0.0 1.0 } /surface
surface cone -0.9 0.0 2.0 translate
surface cone 1.0 -1.0 1.0 scale -30.0 rotatex 0.9 0.5 2.0 translate union /scene
0.5 -1.0 1.0 point 1.0 1.0 1.0 point light /sun
0.2 0.2 0.2 point [ sun ] scene 0 60.0 64 48 "cone.ppm" render
