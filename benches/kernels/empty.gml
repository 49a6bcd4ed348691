% Next to nothing: what is left is the call.
{ /v /u /face u v 0.5 point 0.8 0.2 6.0 }
