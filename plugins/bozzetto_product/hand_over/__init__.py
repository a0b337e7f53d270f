"""Products as other programs have them: files of networks in, shapes out."""
