"""What the small project needs beside its library."""
