% Two mirrors that see each other, tinted as the ICFP rules have it.
{ /v /u /face 0.9 0.7 0.5 point 0.2 0.7 30.0 } sphere -1.05 0.0 2.2 translate
{ /v /u /face 0.5 0.7 0.9 point 0.2 0.7 30.0 } sphere 1.05 0.0 2.2 translate union
{ /v /u /face u floor v floor addi 2 modi 0 eqi { 1.0 } { 0.3 } if /c c c c point 1.0 0.0 1.0 }
plane 0.0 -1.0 0.0 translate union /scene
1.0 -1.0 1.0 point 1.0 1.0 1.0 point light /sun
0.3 0.3 0.3 point [ sun ] scene 6 70.0 64 48 "reflection.ppm" render
